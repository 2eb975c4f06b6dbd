// Tags against rendered truth, and against the pose that the AprilTag library itself estimates.
#include <apriltag/apriltag.h>
#include <apriltag/apriltag_pose.h>
#include <apriltag/tag36h11.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cstdlib>
#include <functional>
#include <memory>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "camera/rendering/tag_renderer.hpp"
#include "imaging/image_codec.hpp"
#include "numeric/random.hpp"
#include "vision/tag_vision.hpp"

namespace multireach {
namespace {

using vision::TagOptions;
using vision::TagVision;

constexpr double kDegree = std::numbers::pi / 180;

StereoRig rig_of(int width, double focal_px, double baseline_m) {
  StereoRig rig;
  rig.left.width = width;
  rig.left.height = width * 3 / 4;
  rig.left.fx = rig.left.fy = focal_px;
  rig.left.cx = (width - 1) / 2.0;
  rig.left.cy = (rig.left.height - 1) / 2.0;
  rig.right = rig.left;
  rig.X_RL = Eigen::Isometry3d::Identity();
  rig.X_RL.translation().x() = -baseline_m;
  rig.X_WL = Eigen::Isometry3d::Identity();
  rig.X_WL.linear() = Eigen::AngleAxisd(2, Eigen::Vector3d(1, -1, 0.3).normalized()).toRotationMatrix();
  rig.X_WL.translation() = Eigen::Vector3d(0.3, -0.2, 0.5);
  return rig;
}

/// A rendered tag before a pair of cameras.
class Scene {
 public:
  Scene(const StereoRig& rig, const TagLook& tag, double noise = 1)
      : rig_(rig),
        left_(options(noise), tag, rig.left, rig.X_WL, rig.X_WL),
        right_(options(noise), tag, rig.right, rig.X_WL * rig.X_RL.inverse(), rig.X_WL) {}

  std::array<cv::Mat, 2> render(const std::optional<Eigen::Isometry3d>& X_LT, uint64_t stream,
                                const Eigen::Vector3d& motion_L = Eigen::Vector3d::Zero()) const {
    std::optional<Eigen::Isometry3d> X_WT;
    if (X_LT) X_WT = rig_.X_WL * *X_LT;
    const Eigen::Vector3d motion = rig_.X_WL.linear() * motion_L;
    return {left_.render(X_WT, 2 * stream, motion), right_.render(X_WT, 2 * stream + 1, motion)};
  }

 private:
  static SceneOptions options(double noise) {
    SceneOptions options;
    options.wall_distance_m = 2;
    options.noise_grey_levels = noise;
    return options;
  }

  StereoRig rig_;
  TagRenderer left_, right_;
};

/// A pair in which one image may be missing. `fingerprints`: by default, the images of all pairs count as repeated.
class Pair final : public vision::StereoImages {
 public:
  Pair(int64_t utime, const std::array<cv::Mat, 2>& bgr, const std::array<int64_t, 2>& fingerprints = {1, 2})
      : utime_(utime), bgr_(bgr), fingerprints_(fingerprints) {}
  vision::PairTimes times() const override {
    return {utime_, bgr_[0].empty() ? -1 : utime_, bgr_[1].empty() ? -1 : utime_};
  }
  bool has(Side side, const cv::Size& size) const override { return bgr_[index(side)].size() == size; }
  int64_t fingerprint(Side side) const override { return fingerprints_[index(side)]; }
  const cv::Mat* pixels(Side side, const cv::Rect&) override { return &bgr_[index(side)]; }

 private:
  int64_t utime_;
  std::array<cv::Mat, 2> bgr_;
  std::array<int64_t, 2> fingerprints_;
};

TagOptions options_for(const StereoRig& rig, const TagLook& tag) {
  TagOptions options;
  options.rig = rig;
  options.id = tag.id;
  options.size.side_m = tag.size_m;
  return options;
}

TagVision::Target answer(const TagOptions& options, const std::array<cv::Mat, 2>& images) {
  TagVision stage({options});
  Pair pair(1000000, images);
  EXPECT_EQ(stage.update(pair), nullptr);
  return stage.targets().front();
}

/// A pose whose paper faces the camera, tilted by `tilt` about an axis in the image.
Eigen::Isometry3d pose_at(const Eigen::Vector3d& p_L, double tilt, double axis, double turn) {
  Eigen::Isometry3d X_LT = Eigen::Isometry3d::Identity();
  X_LT.translation() = p_L;
  X_LT.linear() = (Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(axis), std::sin(axis), 0)) *
                   Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  return X_LT;
}

Eigen::Isometry3d random_pose(uint64_t k, double near, double far) {
  const CounterRandom random(20261122, k);
  const double z = random.uniform(0, near, far);
  return pose_at({z * random.uniform(1, -0.25, 0.25), z * random.uniform(2, -0.2, 0.2), z},
                 random.uniform(3, 0, 55 * kDegree), random.uniform(4, 0, 2 * std::numbers::pi),
                 random.uniform(5, 0, 2 * std::numbers::pi));
}

/// Rotation vector, in W, from the true to the answered orientation.
Eigen::Vector3d turn_between(const StereoRig& rig, const Eigen::Isometry3d& X_LT, const Eigen::Quaterniond& R_WT) {
  const Eigen::AngleAxisd turn(R_WT.toRotationMatrix() * (rig.X_WL.linear() * X_LT.linear()).transpose());
  return turn.angle() * turn.axis();
}

struct Errors {
  int posed = 0, ambiguous = 0, lost = 0, flipped = 0;
  std::vector<double> mm, degrees;
  double nees_position = 0, nees_orientation = 0;

  double quantile(std::vector<double> of, double share) const {
    std::ranges::sort(of);
    return of.empty() ? 0 : of[static_cast<size_t>(share * static_cast<double>(of.size() - 1))];
  }
  /// The rows of a table of docs/, which tools/bench_tables.py takes from the output.
  static void print_head() {
    std::printf(
        "| rendered tags of 6 cm, tilted by up to 55° | distance, m | tags | not seen | without orientation | tilted "
        "the wrong way | "
        "position, mm: median | 95 %% | NEES/3 | orientation, degrees: median | 95 %% | NEES/3 |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  }
  void print(const char* name, double near, double far) const {
    std::printf("| %s | %.1f to %.1f | %d | %d | %d | %d | %.3f | %.3f | %.2f | %.3f | %.3f | %.2f |\n", name, near,
                far, posed + ambiguous + lost, lost, ambiguous, flipped, quantile(mm, 0.5), quantile(mm, 0.95),
                nees_position / (3 * (posed + ambiguous)), quantile(degrees, 0.5), quantile(degrees, 0.95),
                nees_orientation / (3 * posed));
  }
};

enum class Eyes { kBoth, kLeft };

Errors errors_of(const StereoRig& rig, const TagLook& tag, Eyes eyes, double near, double far, int count,
                 int jpeg_quality = 0) {
  const Scene scene(rig, tag);
  const TagOptions options = options_for(rig, tag);
  ImageCodec codec;
  Errors errors;
  for (int k = 0; k < count; ++k) {
    const Eigen::Isometry3d X_LT = random_pose(static_cast<uint64_t>(k), near, far);
    std::array<cv::Mat, 2> images = scene.render(X_LT, static_cast<uint64_t>(k));
    if (eyes == Eyes::kLeft) images[1] = cv::Mat();
    for (cv::Mat& image : images) {
      if (jpeg_quality == 0 || image.empty()) continue;
      const auto bytes = codec.encode_jpeg(image, jpeg_quality);
      cv::Mat decoded;
      EXPECT_TRUE(codec.decode({image.cols, image.rows, 0, PixelFormat::kMjpeg, bytes}, decoded));
      image = decoded;
    }
    const TagVision::Target target = answer(options, images);
    const vision::TagReport& report = target.report;
    if (report.status != vision::TargetTrack::Status::kTracked) {
      ++errors.lost;
      continue;
    }
    const Eigen::Vector3d error = report.estimate.position - rig.X_WL * X_LT.translation();
    errors.mm.push_back(1e3 * error.norm());
    errors.nees_position += error.dot(report.estimate.covariance.inverse() * error);
    if (!report.R_WT) {
      ++errors.ambiguous;
      continue;
    }
    ++errors.posed;
    const Eigen::Vector3d turn = turn_between(rig, X_LT, *report.R_WT);
    errors.degrees.push_back(turn.norm() / kDegree);
    const double nees = turn.dot(report.orientation_covariance.inverse() * turn);
    errors.nees_orientation += nees;
    errors.flipped += turn.norm() > 15 * kDegree;
  }
  return errors;
}

TEST(TagAccuracy, OfRenderedTags) {
  const TagLook tag{7, 0.06};
  constexpr int kPoses = 60;
  struct Case {
    const char* name;
    StereoRig rig;
    Eyes eyes;
    double near, far;
    int jpeg_quality;
    double position_mm, orientation_degrees;  // 95 % at most
  };
  const StereoRig small = rig_of(320, 300, 0.12), large = rig_of(640, 600, 0.12);
  Errors::print_head();
  for (const Case& c : {Case{"320 × 240, both cameras", small, Eyes::kBoth, 0.3, 0.7, 0, 0.3, 0.4},
                        {"320 × 240, one camera", small, Eyes::kLeft, 0.3, 0.7, 0, 1.2, 0.5},
                        {"640 × 480, both cameras", large, Eyes::kBoth, 0.3, 0.9, 0, 0.1, 0.1},
                        {"640 × 480, one camera", large, Eyes::kLeft, 0.3, 0.9, 0, 0.5, 0.3},
                        {"640 × 480, both cameras, JPEG of quality 85", large, Eyes::kBoth, 0.3, 0.9, 85, 0.3, 0.3},
                        {"640 × 480, one camera, JPEG of quality 85", large, Eyes::kLeft, 0.3, 0.9, 85, 1.2, 0.5}}) {
    const Errors errors = errors_of(c.rig, tag, c.eyes, c.near, c.far, kPoses, c.jpeg_quality);
    errors.print(c.name, c.near, c.far);
    EXPECT_EQ(errors.lost, 0) << c.name;
    EXPECT_LE(errors.ambiguous, kPoses / 10) << c.name;
    EXPECT_EQ(errors.flipped, 0) << c.name;
    EXPECT_LT(errors.quantile(errors.mm, 0.95), c.position_mm) << c.name;
    EXPECT_LT(errors.quantile(errors.degrees, 0.95), c.orientation_degrees) << c.name;
    EXPECT_LT(errors.nees_position / (3 * kPoses), 1.25) << c.name;
    EXPECT_LT(errors.nees_orientation / (3 * errors.posed), 1.25) << c.name;
  }
}

TEST(TagAccuracy, FarAwayAnOrientationIsRightOrNotGiven) {
  const TagLook tag{7, 0.06};
  constexpr double kNear = 0.6, kFar = 1.4;
  for (const Eyes eyes : {Eyes::kBoth, Eyes::kLeft}) {
    const Errors errors = errors_of(rig_of(320, 300, 0.12), tag, eyes, kNear, kFar, 100);
    errors.print(eyes == Eyes::kLeft ? "320 × 240, one camera, far" : "320 × 240, both cameras, far", kNear, kFar);
    EXPECT_EQ(errors.flipped, 0);
    EXPECT_GT(errors.posed, 40);
    EXPECT_GE(errors.ambiguous, eyes == Eyes::kLeft ? 10 : 0);
  }
}

/// The library's own pose, from its corners, is a second opinion.
TEST(TagAccuracy, AgreesWithTheLibrarysOwnPose) {
  const TagLook tag{7, 0.06};
  const StereoRig rig = rig_of(640, 600, 0.12);
  const Scene scene(rig, tag);
  const std::unique_ptr<apriltag_family_t, decltype(&tag36h11_destroy)> family(tag36h11_create(), tag36h11_destroy);
  const std::unique_ptr<apriltag_detector_t, decltype(&apriltag_detector_destroy)> detector(apriltag_detector_create(),
                                                                                            apriltag_detector_destroy);
  apriltag_detector_add_family_bits(detector.get(), family.get(), 1);
  detector->quad_decimate = 1;
  double ours_mm = 0, theirs_mm = 0;
  for (uint64_t k = 0; k < 20; ++k) {
    const Eigen::Isometry3d X_LT = random_pose(1000 + k, 0.3, 0.6);
    std::array<cv::Mat, 2> images = scene.render(X_LT, k);
    images[1] = cv::Mat();
    const vision::TagReport report = answer(options_for(rig, tag), images).report;
    ASSERT_TRUE(report.R_WT) << report.reason;
    cv::Mat green;
    cv::extractChannel(images[0], green, 1);
    image_u8_t image{green.cols, green.rows, static_cast<int32_t>(green.step), green.data};
    zarray_t* detections = apriltag_detector_detect(detector.get(), &image);
    ASSERT_EQ(zarray_size(detections), 1) << k;
    apriltag_detection_t* detection = nullptr;
    zarray_get(detections, 0, static_cast<void*>(&detection));
    // The library has the centre of the first pixel at (0.5, 0.5).
    apriltag_detection_info_t info{detection,   tag.size_m,        rig.left.fx,
                                   rig.left.fy, rig.left.cx + 0.5, rig.left.cy + 0.5};
    apriltag_pose_t pose{};
    estimate_tag_pose(&info, &pose);
    const Eigen::Matrix3d R = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose.R->data);
    const Eigen::Vector3d t = Eigen::Map<Eigen::Vector3d>(pose.t->data);
    const Eigen::Isometry3d ours = rig.X_WL.inverse() * (Eigen::Translation3d(report.estimate.position) * *report.R_WT);
    EXPECT_LT((t - ours.translation()).norm(), 0.01 * t.norm()) << k;
    EXPECT_LT(Eigen::AngleAxisd(R.transpose() * ours.linear()).angle() / kDegree, 3) << k;
    ours_mm += 1e3 * (ours.translation() - X_LT.translation()).norm() / 20;
    theirs_mm += 1e3 * (t - X_LT.translation()).norm() / 20;
    std::free(pose.R);  // the library does not export its own function
    std::free(pose.t);
    apriltag_detections_destroy(detections);
  }
  std::printf("mean error of one camera: %.3f mm, the library's own pose %.3f mm\n", ours_mm, theirs_mm);
  EXPECT_LT(ours_mm, theirs_mm);
}

class TagReasons : public ::testing::Test {
 protected:
  const TagLook tag_{7, 0.06};
  const StereoRig rig_ = rig_of(320, 300, 0.12);
  const Eigen::Isometry3d X_LT_ = pose_at({0.02, 0.01, 0.4}, 30 * kDegree, 1, 0.3);

  std::array<cv::Mat, 2> images(const Eigen::Vector3d& motion = Eigen::Vector3d::Zero()) const {
    return Scene(rig_, tag_).render(X_LT_, 3, motion);
  }
  std::string lost_because(const TagOptions& options, const std::array<cv::Mat, 2>& pair) const {
    const vision::TagReport report = answer(options, pair).report;
    EXPECT_EQ(report.status, vision::TargetTrack::Status::kLost);
    EXPECT_FALSE(report.R_WT);
    return report.reason;
  }
};

TEST_F(TagReasons, AnotherId) {
  TagOptions options = options_for(rig_, tag_);
  options.id = 8;
  EXPECT_EQ(lost_because(options, images()), "a tag is seen, but with another id");
}

TEST_F(TagReasons, NoTag) {
  const auto nothing = Scene(rig_, tag_).render(std::nullopt, 3);
  EXPECT_NE(lost_because(options_for(rig_, tag_), nothing).find("no tag is seen"), std::string::npos);
}

TEST_F(TagReasons, TwoTagsWithThisId) {
  auto pair = images();
  for (cv::Mat& image : pair) {
    const cv::Mat tag = image(cv::Rect(130, 80, 90, 90)).clone();
    tag.copyTo(image(cv::Rect(10, 140, 90, 90)));
  }
  EXPECT_EQ(lost_because(options_for(rig_, tag_), pair), "two tags with this id are seen");
  // The one in the other image may be either.
  pair[1] = images()[1];
  EXPECT_EQ(lost_because(options_for(rig_, tag_), pair), "two tags with this id are seen");
}

TEST_F(TagReasons, Blur) {
  const TagOptions options = options_for(rig_, tag_);
  // Motion during the exposure by 2, 6 and 9 pixels, where a cell has 5.6: the tag is measured half-way, or not at all.
  for (const double motion_m : {0.003, 0.008, 0.012}) {
    const vision::TagReport report = answer(options, images({motion_m, 0, 0})).report;
    if (motion_m < 0.005) {
      EXPECT_EQ(report.status, vision::TargetTrack::Status::kTracked) << report.reason;
    }
    if (report.status != vision::TargetTrack::Status::kTracked) continue;
    const Eigen::Vector3d error = report.estimate.position - rig_.X_WL * X_LT_.translation();
    EXPECT_LT(error.dot(report.estimate.covariance.inverse() * error), 20) << motion_m;
    EXPECT_LT(error.norm(), 5e-4) << motion_m;
  }
  // Out of focus, a cell and more.
  auto blurred = images();
  for (cv::Mat& image : blurred) cv::GaussianBlur(image, image, {0, 0}, 2.6);
  const std::string reason = lost_because(options, blurred);
  EXPECT_NE(reason.find("blurred"), std::string::npos) << reason;
  for (const double motion_m : {0.02, 0.04}) {
    EXPECT_NE(lost_because(options, images({motion_m, 0, 0})).find("blurred"), std::string::npos) << motion_m;
  }
}

TEST_F(TagReasons, WrongSizeOrCalibration) {
  TagOptions options = options_for(rig_, tag_);
  options.size.side_m *= 1.04;
  EXPECT_NE(lost_because(options, images()).find("check size_m"), std::string::npos);
  options.size.tolerance_m = 0.003;
  EXPECT_EQ(answer(options, images()).report.status, vision::TargetTrack::Status::kTracked);
  options = options_for(rig_, tag_);
  options.rig.X_RL.linear() = Eigen::AngleAxisd(kDegree, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_NE(lost_because(options, images()).find("check size_m and the calibration"), std::string::npos);
}

// Where the pose by both images would be outside of one of them, the other one alone would give a precise, wrong pose.
TEST_F(TagReasons, ImagesThatContradictEachOtherByMuchAreNotLeftOut) {
  const auto pair = images();
  const auto expect_lost = [&](const TagOptions& options, const std::array<cv::Mat, 2>& shown,
                               const std::string& what) { EXPECT_FALSE(lost_because(options, shown).empty()) << what; };
  for (const double factor : {0.01, 0.05, 0.1, 0.2, 0.5, 2.0, 5.0, 10.0, 100.0}) {
    TagOptions options = options_for(rig_, tag_);
    options.size.side_m *= factor;
    expect_lost(options, pair, "size times " + std::to_string(factor));
  }
  for (const double factor : {0.1, 3.0, 10.0, 40.0}) {
    TagOptions options = options_for(rig_, tag_);
    options.rig.X_RL.translation() *= factor;
    expect_lost(options, pair, "baseline times " + std::to_string(factor));
  }
  for (const double yaw : {-0.6, -0.3, 0.3, 0.6}) {
    TagOptions options = options_for(rig_, tag_);
    options.rig.X_RL.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()).toRotationMatrix();
    expect_lost(options, pair, "yaw of " + std::to_string(yaw));
  }
  expect_lost(options_for(rig_, tag_), {pair[1], pair[0]}, "swapped images");
}

TEST_F(TagReasons, BadOptions) {
  for (const auto& spoil : std::vector<std::function<void(TagOptions&)>>{
           [](TagOptions& o) { o.id = 587; }, [](TagOptions& o) { o.id = -1; },
           [](TagOptions& o) { o.size.side_m = 0; }, [](TagOptions& o) { o.rig.left.fx = 0; },
           [](TagOptions& o) { o.rig.X_RL.setIdentity(); }}) {
    TagOptions options = options_for(rig_, tag_);
    spoil(options);
    EXPECT_THROW(TagVision({options}), std::invalid_argument);
  }
}

TEST_F(TagReasons, ARepeatedImageIsRefusedOnlyWhileThereIsOne) {
  TagVision stage({options_for(rig_, tag_)});
  const std::array<cv::Mat, 2> both = images(), left{both[0], cv::Mat()};
  const auto fault = [&](int k, const std::array<cv::Mat, 2>& images, const std::array<int64_t, 2>& fingerprints) {
    Pair pair(1000000 + 33333 * k, images, fingerprints);
    const char* text = stage.update(pair);
    return std::string(text ? text : "");
  };
  EXPECT_EQ(fault(0, both, {10, 20}), "");
  EXPECT_EQ(fault(1, both, {11, 20}), "the right camera repeats its last image as a new one");
  EXPECT_EQ(fault(2, left, {12, 20}), "") << "the right camera was unplugged";
  EXPECT_EQ(stage.targets().front().report.status, vision::TargetTrack::Status::kTracked);
}

/// A state that was serialized continues with the same bits, and a damaged one is refused.
TEST_F(TagReasons, StateContinues) {
  const Scene scene(rig_, tag_);
  TagVision whole({options_for(rig_, tag_)}), restored = TagVision({options_for(rig_, tag_)});
  std::vector<double> state;
  for (int k = 0; k < 20; ++k) {
    const int64_t utime = 1000000 + 33333 * k;
    Eigen::Isometry3d X_LT = X_LT_;
    X_LT.translation().x() += 0.002 * k;
    const bool covered = k == 12 || k == 13;
    Pair first(utime, scene.render(covered ? std::nullopt : std::optional(X_LT), static_cast<uint64_t>(k)));
    Pair second = first;
    whole.update(first);
    if (k > 0) {
      ASSERT_TRUE(restored.deserialize(utime - 33333, {state}));
    }
    restored.update(second);
    state = whole.serialize(0, utime);
    EXPECT_EQ(state, restored.serialize(0, utime)) << k;
    const auto status = whole.targets().front().report.status;
    EXPECT_EQ(status, covered ? vision::TargetTrack::Status::kCoasting : vision::TargetTrack::Status::kTracked) << k;
    EXPECT_TRUE(whole.targets().front().report.R_WT) << k;
  }
  for (const size_t at : {size_t{0}, state.size() - 8, state.size() - 5}) {
    auto damaged = state;
    damaged[at] = 1e300;
    EXPECT_FALSE(restored.deserialize(2000000, {damaged})) << at;
  }
  EXPECT_FALSE(restored.deserialize(2000000, {std::span<const double>(state).first(3)}));
}

}  // namespace
}  // namespace multireach
