// Vision over many pairs: light that changes, cameras that fail, targets that move, memory that is handed on.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <multireach/debug_request_t.hpp>
#include <multireach/target_t.hpp>
#include <numbers>

#include "camera/node/camera_node.hpp"
#include "camera/node/render_source.hpp"
#include "camera/rendering/ball_renderer.hpp"
#include "imaging/rig_errors.hpp"
#include "runtime/channels.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {
namespace {

constexpr int64_t kFrame = 33333;
const std::string kVisionFile = MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml";
const Eigen::Vector3d kMiddle(0.09, -0.11, 0.08);

struct Cameras {
  explicit Cameras(const StereoRig& r, const SceneOptions& scene = {})
      : rig(r), left(scene, r.left, r.X_WL, r.X_WL), right(scene, r.right, r.X_WL * r.X_RL.inverse(), r.X_WL) {}
  StereoRig rig;
  BallRenderer left, right;
};

/// A message of raw images.
images_t pair_of(const cv::Mat& left, const cv::Mat& right, int64_t utime, int64_t right_utime) {
  images_t pair;
  pair.utime = utime;
  pair.n_images = 2;
  pair.image_types = {images_t::LEFT, images_t::RIGHT};
  for (const auto& [mat, time] : {std::pair(&left, utime), {&right, right_utime}}) {
    image_t& image = pair.images.emplace_back();
    image.utime = time;
    image.width = mat->cols;
    image.height = mat->rows;
    image.pixelformat = image_t::PIXEL_FORMAT_BGR;
    image.data.assign(mat->data, mat->data + mat->total() * mat->elemSize());
    image.size = static_cast<int32_t>(image.data.size());
  }
  return pair;
}

std::vector<target_t> targets_for(VisionNode& vision, const images_t& pair) {
  Outbox out;
  vision.receive(channel::kStereoImages, *encode(pair), out);
  std::vector<target_t> targets;
  for (const OutMessage& message : out) {
    if (message.channel == channel::kTarget) targets.push_back(*decode<target_t>(message.bytes));
  }
  return targets;
}

target_t target_for(VisionNode& vision, const images_t& pair) {
  return targets_for(vision, pair).at(0);
}

Eigen::Vector3d position_of(const target_t& target) {
  return Eigen::Map<const Eigen::Vector3d>(target.position_m);
}

/// The ball on a circle, in a light that changes with time.
struct Light {
  double exposure;
  std::array<double, 3> gains_rgb;
};
Light light_at(double t) {
  const auto ramp = [t](double begin, double from, double to) {
    return from + (to - from) * std::clamp(t - begin, 0.0, 1.0);
  };
  if (t < 2) return {1, {1, 1, 1}};
  if (t < 4) return {0.4, {1, 1, 1}};  // at once, as when a lamp goes out
  if (t < 6) return {2, {1, 1, 1}};
  if (t < 8) return {1, {ramp(6, 1, 1.25), 1, ramp(6, 1, 0.75)}};
  if (t < 10) return {ramp(8, 1, 0.5), {ramp(8, 1.25, 0.75), 1, ramp(8, 0.75, 1.25)}};
  return {ramp(10, 0.5, 1.8), {0.75, ramp(10, 1, 1.25), 1.25}};
}

TEST(VisionSession, HoldsTheBallThroughChangesOfLight) {
  const VisionConfig config = VisionConfig::load(kVisionFile);
  const Cameras cameras(config.rig, {.noise_grey_levels = 3});
  VisionNode vision(config);
  int missed = 0, longest = 0, tracked = 0;
  double sum2 = 0;
  for (int k = 0; k < 360; ++k) {
    const double t = k / 30.0;
    const Light light = light_at(t);
    const ImageConditions look{
        .exposure = light.exposure, .gains_rgb = light.gains_rgb, .occluder = {}, .neighbour = {}};
    const Eigen::Vector3d ball =
        kMiddle + Eigen::Vector3d(0.03 * std::cos(t), 0.05 * std::sin(t), 0.03 * std::sin(2 * t));
    const auto stream = static_cast<uint64_t>(2 * k);
    const target_t target =
        target_for(vision, pair_of(cameras.left.render(ball, stream, look),
                                   cameras.right.render(ball, stream + 1, look), k * kFrame, k * kFrame));
    EXPECT_NE(target.status, target_t::STATUS_LOST) << k << ": held through the change of light";
    const bool seen = target.status == target_t::STATUS_TRACKED;
    missed = seen ? 0 : missed + 1;
    longest = std::max(longest, missed);
    if (!seen) continue;
    ++tracked;
    const double error = (position_of(target) - ball).norm();
    EXPECT_LT(error, 0.5 * config.targets[0].options.match.radius_m) << k << ": inside the ball";
    sum2 += error * error;
  }
  // No bound is known from elsewhere. These guard what was reached when the test was written, with a margin of about a
  // third; by its own covariance the error should be smaller, which it is not while pixels clip.
  EXPECT_LE(longest, 5) << "frames in a row";
  EXPECT_GT(tracked, 350);
  EXPECT_LT(std::sqrt(sum2 / tracked), 0.0015);
}

TEST(VisionSession, VelocityFollowsTheBall) {
  const VisionConfig config = VisionConfig::load(kVisionFile);
  const Cameras cameras(config.rig);
  VisionNode vision(config);
  const double w = 2;
  double sum2 = 0;
  for (int k = 0; k < 120; ++k) {
    const double t = k * kFrame * 1e-6;
    const Eigen::Vector3d ball = kMiddle + Eigen::Vector3d(0, 0.06 * std::sin(w * t), 0);
    const auto stream = static_cast<uint64_t>(2 * k);
    const target_t target = target_for(vision, pair_of(cameras.left.render(ball, stream),
                                                       cameras.right.render(ball, stream + 1), k * kFrame, k * kFrame));
    EXPECT_EQ(target.status, target_t::STATUS_TRACKED);
    EXPECT_EQ(target.last_seen_utime, target.utime);
    if (k < 20) continue;
    const Eigen::Vector3d velocity(0, 0.06 * w * std::cos(w * t), 0);
    sum2 += (Eigen::Map<const Eigen::Vector3d>(target.velocity_m_s) - velocity).squaredNorm() / 100;
  }
  EXPECT_LT(std::sqrt(sum2), 0.03) << "m/s";
}

/// A ball that flies by, in front of two cameras that look level.
struct Throw {
  double frames_per_s, speed_m_s, shutter_s;
  Eigen::Vector3d place(double t) const {
    return {-0.85 + speed_m_s * t, -0.2 - 1.2 * t + 0.5 * 9.81 * t * t, 1.6 - 0.15 * speed_m_s * t};
  }
  Eigen::Vector3d velocity(double t) const { return {speed_m_s, -1.2 + 9.81 * t, -0.15 * speed_m_s}; }
};

TEST(VisionSession, FollowsABallThatIsThrown) {
  VisionConfig config;
  config.rig.left = {.width = 320, .height = 240, .fx = 300, .fy = 300, .cx = 160, .cy = 120, .distortion = {}};
  config.rig.right = config.rig.left;
  config.rig.X_RL = config.rig.X_WL = Eigen::Isometry3d::Identity();
  config.rig.X_RL.translation().x() = -0.12;
  constexpr double kRadius = 0.033;
  vision::TrackerOptions options;
  options.rig = config.rig;
  options.colour.fill(vision::model_of({.references = {{220, 40, 110}}, .tolerance = 0.55}));
  config.targets.push_back({"ball", options});
  const Cameras cameras(config.rig, {.ball_radius_m = kRadius, .wall_distance_m = 3, .noise_grey_levels = 3});
  for (const Throw& thrown : {Throw{30, 3, 0.010}, {30, 8, 0.005}, {60, 6, 0.006}, {60, 8, 0}}) {
    VisionNode vision(config);
    int visible = 0;
    for (int k = 0;; ++k) {
      const double t = k / thrown.frames_per_s;
      const Eigen::Vector3d ball = thrown.place(t);
      const ImageConditions look{.occluder = {}, .neighbour = {}, .motion_W = thrown.velocity(t) * thrown.shutter_s};
      const auto whole_in = [&](const Eigen::Vector3d& p) {
        const Eigen::Vector2d centre = config.rig.left.project(p);
        const double reach = 300 / p.z() * (kRadius + look.motion_W.norm() / 2) + 2;
        return centre.x() > reach && centre.y() > reach && centre.x() < 319 - reach && centre.y() < 239 - reach;
      };
      const bool whole = whole_in(ball) && whole_in(config.rig.X_RL * ball);
      if (!whole && visible > 0) break;
      const auto utime = static_cast<int64_t>(1e6 * t);
      const auto stream = static_cast<uint64_t>(2 * k);
      const cv::Mat left = cameras.left.render(ball, stream, look),
                    right = cameras.right.render(ball, stream + 1, look);
      const target_t target = target_for(vision, pair_of(left, right, utime, utime));
      if (!whole) continue;
      ++visible;
      EXPECT_EQ(target.status, target_t::STATUS_TRACKED)
          << thrown.speed_m_s << " m/s, " << thrown.frames_per_s << " Hz, frame " << k << ": " << target.reason;
      // A centimetre at 1.5 m is a fifth of a pixel of disparity; what is blurred is measured to half a pixel.
      EXPECT_LT((position_of(target) - ball).norm(), thrown.shutter_s > 0 ? 0.05 : 0.01);
      if (visible > 4) {
        EXPECT_LT((Eigen::Map<const Eigen::Vector3d>(target.velocity_m_s) - thrown.velocity(t)).norm(), 1) << "m/s";
      }
    }
    EXPECT_GE(visible, 5) << thrown.speed_m_s << " m/s";
  }
}

TEST(VisionSession, MemoryStaysFlat) {
  // Bytes in use, small blocks and large ones; no number of calls, for buffers may come and go.
  const auto in_use = [] {
    const struct mallinfo2 heap = mallinfo2();
    return static_cast<int64_t>(heap.uordblks + heap.hblkhd);
  };
  if (in_use() == 0) GTEST_SKIP() << "a sanitizer's heap does not say what is in use";
  const char* asked = std::getenv("MULTIREACH_FRAMES");
  const int64_t frames = asked ? std::atoll(asked) : 3000;
  const VisionConfig config = VisionConfig::load(kVisionFile);
  const Cameras cameras(config.rig, {.noise_grey_levels = 3});
  VisionNode vision(config);
  ImageCodec codec;
  constexpr int64_t kPlaces = 24;
  std::vector<images_t> pairs;
  for (int64_t k = 0; k < kPlaces; ++k) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / kPlaces;
    const Eigen::Vector3d ball = kMiddle + Eigen::Vector3d(0, 0.03 * std::cos(angle), 0.03 * std::sin(angle));
    images_t pair = pair_of(cameras.left.render(ball, static_cast<uint64_t>(2 * k)),
                            cameras.right.render(ball, static_cast<uint64_t>(2 * k + 1)), 0, 0);
    for (image_t& image : pair.images) {
      const cv::Mat bgr(image.height, image.width, CV_8UC3, image.data.data());
      image.data = codec.encode_jpeg(bgr, 85);
      image.size = static_cast<int32_t>(image.data.size());
      image.pixelformat = image_t::PIXEL_FORMAT_MJPEG;
    }
    pairs.push_back(std::move(pair));
  }
  int64_t before = 0, tracked = 0;
  for (int64_t k = 0; k < frames; ++k) {
    if (k == frames / 3) before = in_use();
    images_t& pair = pairs[static_cast<size_t>(k % kPlaces)];
    pair.utime = k * kFrame;
    for (image_t& image : pair.images) image.utime = pair.utime;
    // Every tenth second there is no right image for half a second.
    pair.image_types[1] = k % 300 < 285 ? images_t::RIGHT : images_t::LEFT;
    tracked += target_for(vision, pair).status == target_t::STATUS_TRACKED;
  }
  EXPECT_GT(tracked, frames * 9 / 10);
  EXPECT_LT(in_use() - before, 64 * 1024) << "bytes more than after a third of " << frames << " pairs";
}

TEST(VisionSession, ExposuresAtDifferentTimesAreTakenToOne) {
  const VisionConfig config = VisionConfig::load(kVisionFile);
  const Cameras cameras(config.rig);
  VisionNode with_times(config), without_times(config);
  constexpr int64_t kSkew = 8000;
  double error_with_times = 0, error_without_times = 0;
  for (int k = 0; k < 40; ++k) {
    const auto ball_at = [&](int64_t utime) {
      return (kMiddle + Eigen::Vector3d(0, 0.25 * (static_cast<double>(utime) * 1e-6 - 0.6), 0)).eval();
    };
    const int64_t utime = k * kFrame;
    const auto stream = static_cast<uint64_t>(2 * k);
    const cv::Mat left = cameras.left.render(ball_at(utime), stream);
    const cv::Mat right = cameras.right.render(ball_at(utime + kSkew), stream + 1);
    const target_t a = target_for(with_times, pair_of(left, right, utime, utime + kSkew));
    const target_t b = target_for(without_times, pair_of(left, right, utime, utime));
    if (k < 10) continue;
    EXPECT_EQ(a.status, target_t::STATUS_TRACKED);
    error_with_times = std::max(error_with_times, (position_of(a) - ball_at(utime)).norm());
    error_without_times = std::max(error_without_times, (position_of(b) - ball_at(utime)).norm());
  }
  EXPECT_LT(error_with_times, 0.005);
  EXPECT_GT(error_without_times, 0.008);
}

/// Pairs of the recorded scene.
class Scene {
 public:
  images_t next() {
    Outbox out;
    camera_.tick(out);
    for (const OutMessage& message : out) {
      if (message.channel == channel::kStereoImages) return *decode<images_t>(message.bytes);
    }
    return {};
  }

 private:
  CameraNode camera_{std::make_unique<RenderSource>(MULTIREACH_SOURCE_DIR "/logs/reach.yaml")};
};

std::string reason_of(VisionNode& vision, const images_t& pair) {
  const target_t target = target_for(vision, pair);
  EXPECT_NE(target.status, target_t::STATUS_TRACKED) << target.reason;
  return target.reason;
}

TEST(VisionSession, SaysWhatIsWrongWithTheCameras) {
  const VisionConfig config = VisionConfig::load(kVisionFile);
  const cv::Mat black(240, 320, CV_8UC3, cv::Scalar(2, 3, 2)), pink(240, 320, CV_8UC3, cv::Scalar(110, 40, 220));
  {
    Scene scene;
    VisionNode vision(config);
    images_t pair = scene.next();
    std::swap(pair.images[0].data, pair.images[1].data);
    std::swap(pair.images[0].size, pair.images[1].size);
    EXPECT_EQ(reason_of(vision, pair), "the left and the right image seem to be swapped");
  }
  {
    const Cameras cameras(config.rig);
    VisionNode vision(config);
    EXPECT_EQ(reason_of(vision, pair_of(black, cameras.right.render(kMiddle, 1), 0, 0)), "the left image is black");
    EXPECT_EQ(reason_of(vision, pair_of(cameras.left.render(kMiddle, 0), black, kFrame, kFrame)),
              "the right image is black");
    EXPECT_EQ(reason_of(vision, pair_of(pink, cv::Mat(pink + cv::Scalar(1, 0, 0)), 2 * kFrame, 2 * kFrame)),
              "the colour fills most of an image: the colour model is too wide");
    EXPECT_EQ(reason_of(vision, pair_of(black(cv::Rect(0, 0, 100, 100)).clone(), black, 3 * kFrame, 3 * kFrame)),
              "the size of an image differs from the calibration");
    const cv::Mat left = cameras.left.render(kMiddle, 0);
    EXPECT_EQ(reason_of(vision, pair_of(left, left, 4 * kFrame, 4 * kFrame)),
              "the left and the right image are the same");
  }
  {
    Scene scene;
    VisionNode vision(config);
    images_t pair = scene.next();
    const std::vector<uint8_t> still = pair.images[1].data;
    std::string reason;
    for (int k = 0; k < 10; ++k) {
      pair = scene.next();
      pair.images[1].data = still;
      pair.images[1].size = static_cast<int32_t>(still.size());
      reason = target_for(vision, pair).reason;
    }
    EXPECT_EQ(reason, "the right camera is frozen: it repeats the same image");
    EXPECT_EQ(target_for(vision, scene.next()).status, target_t::STATUS_TRACKED) << "and goes on";
  }
}

TEST(VisionSession, GoesOnFromWhatItSaid) {
  const VisionConfig config = VisionConfig::load(kVisionFile);
  VisionNode vision(config);
  Scene scene;
  std::vector<uint8_t> before;
  for (int k = 0; k < 40; ++k) {
    Outbox sent, again;
    images_t pair = scene.next();
    if (k % 10 == 7) pair.utime -= 50000;  // late
    const auto bytes = *encode(pair);
    vision.receive(channel::kStereoImages, bytes, sent);
    ASSERT_EQ(sent.size(), 2U);
    ASSERT_EQ(sent[1].channel, channel::kTrackerState);
    if (k > 0) {
      // All that it remembers is in what it said for the pair before.
      VisionNode other(config);
      other.skip_inputs(k - 1, "");
      ASSERT_TRUE(other.restore_from_outputs({before}));
      other.receive(channel::kStereoImages, bytes, again);
      ASSERT_EQ(again.size(), 2U);
      EXPECT_EQ(again[0].bytes, sent[0].bytes) << k;
      EXPECT_EQ(again[1].bytes, sent[1].bytes) << k;
    }
    before = sent[1].bytes;
  }
}

TEST(VisionSession, TheSameWhetherDecodedBeforehandOrAsNeeded) {
  const VisionConfig config = VisionConfig::load(kVisionFile);
  VisionNode live(config, 2), ahead(config);
  ImageCodec codec;
  Scene scene;
  for (int k = 0; k < 60; ++k) {
    const auto bytes = *encode(scene.next());
    StereoFrames frames(bytes);
    for (const Side side : {Side::kLeft, Side::kRight}) ASSERT_TRUE(frames.pixels(side, {0, 0, 320, 240}, codec));
    Outbox a, b;
    live.receive(channel::kStereoImages, bytes, a);
    ahead.process(frames, b);
    ASSERT_EQ(a.size(), 2U);
    ASSERT_EQ(b.size(), 2U);
    ASSERT_EQ(a[0].bytes, b[0].bytes) << k;
    ASSERT_EQ(a[1].bytes, b[1].bytes) << k;
  }
}

TEST(VisionSession, ReportsTheErrorsOfTheCalibrationButDoesNotTrackByThem) {
  VisionConfig config = VisionConfig::load(kVisionFile);
  vision::TrackerOptions& options = config.targets.front().options;
  options.match.radius_m = 0;  // a known radius is compared with the measured one, for which these errors count
  VisionNode exact(config);
  config.rig.errors.covariance.diagonal() << 1e-5, 1e-5, 1e-8, 1e-6, 1e-6;
  options.rig = config.rig;
  VisionNode doubtful(config);
  Scene scene;
  std::vector<int8_t> seen;
  for (int k = 0; k < 40; ++k) {
    images_t pair = scene.next();
    if (k % 8 == 7) std::ranges::fill(pair.images[0].data, uint8_t{90});  // damaged
    const auto bytes = *encode(pair);
    Outbox a, b;
    exact.receive(channel::kStereoImages, bytes, a);
    doubtful.receive(channel::kStereoImages, bytes, b);
    ASSERT_EQ(a.size(), b.size());
    EXPECT_EQ(a[1].bytes, b[1].bytes) << "the tracker's state, pair " << k;
    const auto without = *decode<target_t>(a[0].bytes), with = *decode<target_t>(b[0].bytes);
    EXPECT_EQ(position_of(with), position_of(without));
    Eigen::Matrix3d expected = Eigen::Map<const Eigen::Matrix3d>(&without.covariance_m2[0][0]);
    if (with.status != target_t::STATUS_LOST) expected += covariance_by_rig_errors(config.rig, position_of(with));
    EXPECT_LT((Eigen::Map<const Eigen::Matrix3d>(&with.covariance_m2[0][0]) - expected).norm(), 1e-12);
    seen.push_back(with.status);
  }
  EXPECT_GT(std::ranges::count(seen, target_t::STATUS_TRACKED), 20);
  EXPECT_GT(std::ranges::count(seen, target_t::STATUS_COASTING), 1);
}

TEST(VisionSession, SeveralTargetsByName) {
  VisionConfig config = VisionConfig::load(kVisionFile);
  VisionConfig::Target card = config.targets.front();
  card.name = "card";
  card.options.colour.fill(vision::model_of({.references = {{20, 120, 230}}, .tolerance = 0.4}));
  card.options.match.radius_m = 0;
  config.targets.push_back(card);
  const Cameras cameras(config.rig);
  VisionNode vision(config);
  EXPECT_EQ(vision.sent_per_input(), 2);
  ImageConditions look;
  look.neighbour = Neighbour{.angle_rad = 0.3, .radius_m = 0.02, .gap_m = 0.02, .colour = {20, 120, 230}};
  for (int k = 0; k < 5; ++k) {
    const auto stream = static_cast<uint64_t>(2 * k);
    const std::vector<target_t> targets =
        targets_for(vision, pair_of(cameras.left.render(kMiddle, stream, look),
                                    cameras.right.render(kMiddle, stream + 1, look), k * kFrame, k * kFrame));
    ASSERT_EQ(targets.size(), 2U);
    EXPECT_EQ(targets[0].name, "ball");
    EXPECT_EQ(targets[1].name, "card");
    EXPECT_EQ(targets[0].sequence, 2 * k);
    EXPECT_EQ(targets[1].sequence, 2 * k + 1);
    EXPECT_EQ(targets[0].status, target_t::STATUS_TRACKED) << targets[0].reason;
    EXPECT_LT((position_of(targets[0]) - kMiddle).norm(), 0.003);
  }
}

TEST(VisionSession, APictureOnlyForThoseWhoAsk) {
  VisionNode vision(VisionConfig::load(kVisionFile));
  Scene scene;
  const auto pictures = [&] {
    Outbox out;
    vision.receive(channel::kStereoImages, *encode(scene.next()), out);
    return std::ranges::count(out, channel::kVisionDebug, &OutMessage::channel);
  };
  EXPECT_EQ(pictures(), 0);
  Outbox out;
  vision.receive(channel::kVisionDebugRequest, *encode(debug_request_t{}), out);
  int sent = 0;
  for (int k = 0; k < 100; ++k) sent += static_cast<int>(pictures());
  EXPECT_GE(sent, 19);
  EXPECT_LE(sent, 21) << "two seconds, of each third pair at 30 Hz";
}

}  // namespace
}  // namespace multireach
