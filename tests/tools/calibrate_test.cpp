// Calibration from rendered boards, whose cameras are known, and from real photographs.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "numeric/random.hpp"
#include "numeric/trigonometry.hpp"
#include "runtime/camera_files.hpp"
#include "tools/calibrate/board_images.hpp"
#include "tools/calibrate/reprojection_picture.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {
namespace {

const Board kBoard{.columns = 9, .rows = 6, .square_m = 0.03};

StereoRig hoap2_rig() {
  return VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml").rig;
}

/// What one camera sees of a board with a white border, each pixel the mean over 5 x 5 rays, with noise.
class BoardRenderer {
 public:
  explicit BoardRenderer(const CameraModel& camera) : camera_(camera) {
    std::vector<Eigen::Vector2d> corners;
    for (int row = 0; row <= camera.height; ++row) {
      for (int column = 0; column <= camera.width; ++column) corners.emplace_back(column - 0.5, row - 0.5);
    }
    rays_ = camera.rays(corners);
  }

  /// `X_CB`: the board in the camera's frame.
  cv::Mat render(const Eigen::Isometry3d& X_CB, uint64_t stream) const {
    const CounterRandom random(4, stream);
    const Eigen::Isometry3d X_BC = X_CB.inverse();
    const double eye_x = X_BC.translation().x(), eye_y = X_BC.translation().y(), eye_z = X_BC.translation().z();
    // In the board's frame. Plain numbers: there are millions of rays, and sanitizers watch each call.
    std::vector<std::array<double, 3>> rays(rays_.size());
    for (size_t i = 0; i < rays.size(); ++i)
      Eigen::Map<Eigen::Vector3d>(rays[i].data()) = X_BC.linear() * rays_[i].homogeneous();
    cv::Mat image(camera_.height, camera_.width, CV_8UC1);
    for (int row = 0; row < image.rows; ++row) {
      for (int column = 0; column < image.cols; ++column) {
        constexpr int kGrid = 5;
        const size_t at = static_cast<size_t>(row * (camera_.width + 1) + column),
                     below = at + static_cast<size_t>(camera_.width) + 1;
        double sum = 0;
        for (int k = 0; k < kGrid * kGrid; ++k) {
          const double u = (k % kGrid + 0.5) / kGrid, v = (k / kGrid + 0.5) / kGrid;
          std::array<double, 3> ray;
          for (size_t i = 0; i < 3; ++i) {
            ray[i] = (1 - v) * ((1 - u) * rays[at][i] + u * rays[at + 1][i]) +
                     v * ((1 - u) * rays[below][i] + u * rays[below + 1][i]);
          }
          const double along = eye_z / ray[2];
          sum += shade((eye_x - ray[0] * along) / kBoard.square_m, (eye_y - ray[1] * along) / kBoard.square_m);
        }
        double noise = -2;
        const auto first = static_cast<uint64_t>(4 * (row * image.cols + column));
        for (uint64_t k = 0; k < 4; ++k) noise += random.uniform(first + k);
        image.at<uint8_t>(row, column) = cv::saturate_cast<uint8_t>(sum / (kGrid * kGrid) + 3 * noise);
      }
    }
    return image;
  }

 private:
  static double shade(double x, double y) {
    if (x < -2 || y < -2 || x > kBoard.columns + 1 || y > kBoard.rows + 1) return 110;
    const bool squares = x > -1 && y > -1 && x < kBoard.columns && y < kBoard.rows;
    const bool black = (static_cast<int>(std::floor(x)) + static_cast<int>(std::floor(y))) % 2 == 0;
    return squares && black ? 30 : 210;
  }

  CameraModel camera_;
  std::vector<Eigen::Vector2d> rays_;
};

/// Poses of the board in the left camera's frame: tilted in all directions, all over the images.
std::vector<Eigen::Isometry3d> board_poses(size_t count, const StereoRig& rig) {
  const CounterRandom random(8);
  const std::vector<cv::Point3f> corners = kBoard.corners();
  std::vector<Eigen::Isometry3d> poses;
  for (uint64_t at = 0; poses.size() < count; at += 6) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = rotation_from_rpy(
        {random.uniform(at, -0.6, 0.6), random.uniform(at + 1, -0.6, 0.6), random.uniform(at + 2, -0.4, 0.4)});
    X.translation() = Eigen::Vector3d(random.uniform(at + 3, -0.15, 0.2), random.uniform(at + 4, -0.15, 0.15),
                                      random.uniform(at + 5, 0.35, 0.6));
    X = X * Eigen::Translation3d(-4 * kBoard.square_m, -2.5 * kBoard.square_m, 0);
    const auto inside = [&](const CameraModel& camera, const Eigen::Isometry3d& X_CB) {
      return std::ranges::all_of(corners, [&](const cv::Point3f& corner) {
        const Eigen::Vector3d p = X_CB * Eigen::Vector3d(corner.x, corner.y, 0);
        if (p.z() < 0.2) return false;
        const Eigen::Vector2d pixel = camera.project(p);
        return pixel.x() > 18 && pixel.y() > 18 && pixel.x() < camera.width - 18 && pixel.y() < camera.height - 18;
      });
    };
    if (inside(rig.left, X) && inside(rig.right, rig.X_RL * X)) poses.push_back(X);
  }
  return poses;
}

/// Rendered once for all tests: it takes a second or two.
struct RenderedSession {
  StereoRig rig = hoap2_rig();
  cv::Size size{rig.left.width, rig.left.height};
  std::vector<Eigen::Isometry3d> poses = board_poses(16, rig);
  std::vector<BoardPair> pairs;

  RenderedSession() {
    const BoardRenderer left(rig.left), right(rig.right);
    for (size_t k = 0; k < poses.size(); ++k) {
      const auto l = find_board(left.render(poses[k], 2 * k), kBoard),
                 r = find_board(right.render(rig.X_RL * poses[k], 2 * k + 1), kBoard);
      if (!l || !r) continue;
      pairs.push_back({*l, *r});
      match_corner_order(kBoard, pairs.back().left, pairs.back().right);
    }
  }
  static const RenderedSession& get() {
    static const RenderedSession session;
    return session;
  }
};

double angle_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(a.linear().transpose() * b.linear())).angle();
}

TEST(Chessboard, ItsSizeIsFound) {
  const RenderedSession& session = RenderedSession::get();
  const BoardRenderer left(session.rig.left), right(session.rig.right);
  int found = 0;
  for (size_t k = 0; k < session.poses.size(); ++k) {
    const auto size = find_board_size(left.render(session.poses[k], 2 * k),
                                      right.render(session.rig.X_RL * session.poses[k], 2 * k + 1));
    if (!size) continue;
    ++found;
    EXPECT_EQ(*size, cv::Size(kBoard.columns, kBoard.rows)) << k;
  }
  EXPECT_GT(found, static_cast<int>(session.poses.size()) / 2);
  const cv::Mat grey(240, 320, CV_8UC1, cv::Scalar(128));
  EXPECT_FALSE(find_board_size(grey, grey));
}

TEST(Chessboard, CornersAreFoundWhereTheyAre) {
  const RenderedSession& session = RenderedSession::get();
  ASSERT_EQ(session.pairs.size(), session.poses.size());
  double sum2 = 0;
  Eigen::Vector2d bias(0, 0);
  int count = 0;
  for (size_t k = 0; k < session.poses.size(); ++k) {
    Corners truth;
    for (const cv::Point3f& corner : kBoard.corners()) {
      const Eigen::Vector2d pixel = session.rig.left.project(session.poses[k] * Eigen::Vector3d(corner.x, corner.y, 0));
      truth.emplace_back(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
    }
    Corners found = session.pairs[k].left;
    match_corner_order(kBoard, truth, found);
    for (size_t c = 0; c < truth.size(); ++c, ++count) {
      const cv::Point2f error = found[c] - truth[c];
      sum2 += error.dot(error);
      bias += Eigen::Vector2d(error.x, error.y);
    }
  }
  bias /= count;
  std::printf("corners: %.4f px rms, bias %.4f, %.4f px\n", std::sqrt(sum2 / count), bias.x(), bias.y());
  EXPECT_LT(std::sqrt(sum2 / count), 0.1);
  EXPECT_LT(bias.norm(), 0.02) << "pixels have their centre at whole numbers";
}

TEST(Chessboard, LargeImagesAreSearchedSmallAndMeasuredWhole) {
  const RenderedSession& session = RenderedSession::get();
  const cv::Mat image = BoardRenderer(session.rig.left).render(session.poses[0], 0);
  constexpr float kScale = 5;
  cv::Mat large;
  cv::resize(image, large, {}, kScale, kScale, cv::INTER_CUBIC);
  auto found = find_board(large, kBoard);
  ASSERT_TRUE(found.has_value());
  Corners expected = session.pairs[0].left;
  for (cv::Point2f& corner : expected) corner = (corner + cv::Point2f(0.5F, 0.5F)) * kScale - cv::Point2f(0.5F, 0.5F);
  match_corner_order(kBoard, expected, *found);
  cv::Point2f bias(0, 0);
  for (size_t k = 0; k < expected.size(); ++k) {
    EXPECT_LT(cv::norm((*found)[k] - expected[k]), 0.3 * kScale) << k;
    bias += ((*found)[k] - expected[k]) / static_cast<float>(expected.size());
  }
  EXPECT_LT(cv::norm(bias), 0.02 * kScale);
}

TEST(Chessboard, BothImagesAreCountedAlike) {
  const RenderedSession& session = RenderedSession::get();
  const BoardPair& pair = session.pairs.front();
  Corners turned(pair.right.rbegin(), pair.right.rend());
  match_corner_order(kBoard, pair.left, turned);
  EXPECT_EQ(turned, pair.right);
  // As many rows as columns: four ways.
  const Board square{.columns = 4, .rows = 4, .square_m = 0.01};
  Corners first;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) first.emplace_back(static_cast<float>(column), static_cast<float>(row));
  }
  Corners quarter(16);
  for (size_t k = 0; k < 16; ++k) quarter[k] = first[(k % 4) * 4 + 3 - k / 4];
  match_corner_order(square, first, quarter);
  EXPECT_EQ(quarter, first);
  EXPECT_FALSE(find_board(cv::Mat(240, 320, CV_8UC1, cv::Scalar(128)), kBoard).has_value());
}

TEST(StereoCalibration, RenderedBoardsGiveTheirCamerasBack) {
  const RenderedSession& session = RenderedSession::get();
  const StereoCalibration result = calibrate(session.pairs, kBoard, session.size, Lens::kRadtan, false);
  const StereoRig &rig = result.rig, &truth = session.rig;
  std::printf(
      "rms %.4f px, fx %.2f +- %.2f (%.2f), cx %.2f (%.2f), k1 %.4f (%.4f), baseline %.3f (%.3f) mm, turned by %.2f "
      "mrad\n",
      result.stereo_rms_px, rig.left.fx, result.left_fx_sigma_px, truth.left.fx, rig.left.cx, truth.left.cx,
      rig.left.distortion[0], truth.left.distortion[0], 1e3 * rig.baseline_m(), 1e3 * truth.baseline_m(),
      1e3 * angle_between(rig.X_RL, truth.X_RL));
  EXPECT_LT(result.stereo_rms_px, 0.1);
  for (const auto& [camera, true_camera] : {std::pair(&rig.left, &truth.left), {&rig.right, &truth.right}}) {
    EXPECT_NEAR(camera->fx, true_camera->fx, 0.003 * true_camera->fx);
    EXPECT_NEAR(camera->fy, true_camera->fy, 0.003 * true_camera->fy);
    EXPECT_NEAR(camera->cx, true_camera->cx, 1);
    EXPECT_NEAR(camera->cy, true_camera->cy, 1);
    EXPECT_NEAR(camera->distortion[0], true_camera->distortion[0], 0.02);
    EXPECT_EQ(camera->distortion[4], 0) << "k3 is not of this lens model";
  }
  // Along the axes the cameras' distance is hardly seen; what counts is where points are said to be.
  double sum2 = 0;
  int count = 0;
  for (const Eigen::Isometry3d& X_LB : session.poses) {
    for (const cv::Point3f& corner : kBoard.corners()) {
      const Eigen::Vector3d p_L = X_LB * Eigen::Vector3d(corner.x, corner.y, 0);
      const auto seen = [&p_L](const CameraModel& said_camera, const CameraModel& true_camera,
                               const Eigen::Isometry3d& X_CL) -> vision::RayMeasurement {
        return {said_camera.ray(true_camera.project(X_CL * p_L)), vision::ray_covariance(said_camera, 1)};
      };
      const auto said = vision::triangulate(rig, seen(rig.left, truth.left, Eigen::Isometry3d::Identity()),
                                            seen(rig.right, truth.right, truth.X_RL));
      ASSERT_TRUE(said.has_value());
      sum2 += (said->p_W - p_L).squaredNorm();
      ++count;
    }
  }
  std::printf("points at 0.35 to 0.6 m: %.3f mm rms\n", 1e3 * std::sqrt(sum2 / count));
  EXPECT_LT(std::sqrt(sum2 / count), 1e-3);
  EXPECT_LT((rig.X_RL.translation() - truth.X_RL.translation()).head<2>().norm(), 0.3e-3);
  EXPECT_LT(angle_between(rig.X_RL, truth.X_RL), 3e-3);
  for (const PairFit& fit : result.fits) EXPECT_FALSE(fit.poor);

  // The same boards said to be of twice the size are twice as far apart.
  Board twice = kBoard;
  twice.square_m *= 2;
  EXPECT_NEAR(calibrate(session.pairs, twice, session.size, Lens::kRadtan, false).rig.baseline_m(),
              2 * rig.baseline_m(), 1e-6);

  const cv::Mat picture = reprojection_picture(session.pairs, result, session.size);
  EXPECT_GT(picture.cols, 1000);
  EXPECT_EQ(picture.type(), CV_8UC3);
}

TEST(StereoCalibration, PairsOfAMovedBoardAreFoundAndLeftOut) {
  const RenderedSession& session = RenderedSession::get();
  std::vector<BoardPair> pairs = session.pairs;
  // The right image of the pair was taken when the board had moved on; of another, one corner is wrong.
  for (cv::Point2f& corner : pairs[4].right) corner += cv::Point2f(3, 6);
  pairs[9].left[20] += cv::Point2f(9, -4);
  const StereoCalibration named = calibrate(pairs, kBoard, session.size, Lens::kRadtan, false);
  EXPECT_TRUE(named.fits[4].poor);
  EXPECT_TRUE(named.fits[4].used);
  const StereoCalibration left_out = calibrate(pairs, kBoard, session.size, Lens::kRadtan, true);
  for (size_t k = 0; k < pairs.size(); ++k) {
    EXPECT_EQ(left_out.fits[k].poor, k == 4 || k == 9) << k;
    EXPECT_EQ(left_out.fits[k].used, !left_out.fits[k].poor) << k;
  }
  EXPECT_LT(left_out.stereo_rms_px, 0.1);
  EXPECT_GT(left_out.fits[4].rms_px(), 0.5);
}

// Each camera alone fits, but the board had moved on between the exposures of most pairs.
TEST(StereoCalibration, PairsOfDifferentTimesContradict) {
  const RenderedSession& session = RenderedSession::get();
  std::vector<BoardPair> pairs = session.pairs;
  for (size_t k = 0; k < pairs.size(); ++k) {
    const float moved = k % 3 == 0 ? 2.0F : k % 3 == 1 ? -2.0F : 0.0F;
    for (cv::Point2f& corner : pairs[k].right) corner.y += moved;
  }
  EXPECT_TRUE(calibrate(pairs, kBoard, session.size, Lens::kRadtan, false).pairs_contradict());
  EXPECT_FALSE(calibrate(session.pairs, kBoard, session.size, Lens::kRadtan, false).pairs_contradict());
}

TEST(StereoCalibration, SwappedCamerasAreRefused) {
  std::vector<BoardPair> pairs = RenderedSession::get().pairs;
  for (BoardPair& pair : pairs) std::swap(pair.left, pair.right);
  const StereoCalibration result = calibrate(pairs, kBoard, RenderedSession::get().size, Lens::kRadtan, false);
  try {
    check_rig(result.rig, "--left");
    FAIL() << "swapped cameras were taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("the cameras are swapped"), std::string::npos) << error.what();
  }
}

TEST(StereoCalibration, TooFewOrAllAlikePairsAreRefused) {
  const RenderedSession& session = RenderedSession::get();
  const std::vector<BoardPair> two(session.pairs.begin(), session.pairs.begin() + 2);
  EXPECT_THROW(calibrate(two, kBoard, session.size, Lens::kPlumbBob, false), std::runtime_error);
  const std::vector<BoardPair> alike(5, session.pairs[0]);
  EXPECT_THROW(calibrate(alike, kBoard, session.size, Lens::kRadtan, false), std::runtime_error);
}

TEST(StereoCalibration, RealPhotographsOfOpenCv) {
  const std::string folder = "/usr/share/doc/opencv-doc/examples/data/";
  if (!std::filesystem::exists(folder + "left01.jpg")) GTEST_SKIP() << "Debian's opencv-doc is not installed";
  const Board board{.columns = 9, .rows = 6, .square_m = 0.025};
  const BoardImages images = find_boards(folder + "left[01]?.jpg", folder + "right[01]?.jpg", board, [](double) {});
  ASSERT_EQ(images.pairs.size(), 13U);
  EXPECT_TRUE(images.warnings.empty());
  const StereoCalibration result = calibrate(images.pairs, board, images.size, Lens::kPlumbBob, false);
  const std::vector<double> left_out =
      leave_one_out(images.pairs, board, images.size, Lens::kPlumbBob, result, [](double) {});
  std::printf("stereo rms %.4f px; left-out corners: median %.4f squares\n", result.stereo_rms_px,
              left_out[left_out.size() / 2]);
  EXPECT_LE(result.stereo_rms_px, 0.22);
  EXPECT_FALSE(result.pairs_contradict());
  ASSERT_EQ(left_out.size(), 13U * 54);
  EXPECT_LE(left_out[left_out.size() / 2], 0.02);
  double sum2 = 0;
  for (const PairFit& fit : result.fits) {
    EXPECT_FALSE(fit.poor);
    sum2 += fit.rms_px() * fit.rms_px() / 13;
  }
  EXPECT_NEAR(std::sqrt(sum2), result.stereo_rms_px, 1e-4) << "the pairs' own residuals are those of OpenCV";
}

}  // namespace
}  // namespace multireach
