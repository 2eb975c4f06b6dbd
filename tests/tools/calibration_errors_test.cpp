// Whether the errors that a calibration claims are those that it has: many calibrations of one pair of cameras, each
// from other boards and other noise.
#include "tools/calibrate/calibration_errors.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <filesystem>

#include "imaging/rig_errors.hpp"
#include "numeric/gaussian.hpp"
#include "numeric/trigonometry.hpp"
#include "tools/calibrate/board_images.hpp"
#include "vision/stereo/triangulate.hpp"

namespace multireach {
namespace {

const Board kBoard{.columns = 9, .rows = 6, .square_m = 0.025};

StereoRig true_rig() {
  StereoRig rig;
  rig.left = {.width = 640,
              .height = 480,
              .fx = 530,
              .fy = 531,
              .cx = 326,
              .cy = 236,
              .distortion = {-0.24, 0.09, 0.0006, -0.0004}};
  rig.right = {.width = 640,
               .height = 480,
               .fx = 527,
               .fy = 527,
               .cx = 317,
               .cy = 245,
               .distortion = {-0.23, 0.08, -0.0005, 0.0003}};
  rig.X_RL = rig.X_WL = Eigen::Isometry3d::Identity();
  rig.X_RL.linear() = rotation_from_rpy({0.01, 0.03, -0.008});
  rig.X_RL.translation() = Eigen::Vector3d(-0.08, 0.001, 0.002);
  return rig;
}

/// Corners of boards at random poses that both cameras see, with noise of `sigma_px` each and a bent board.
std::vector<BoardPair> board_pairs(const StereoRig& rig, uint64_t seed, size_t count, double sigma_px, double bend_m) {
  const CounterRandom random(seed);
  uint64_t counter = 1000000;
  std::vector<BoardPair> pairs;
  for (uint64_t at = 0; pairs.size() < count; at += 7) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = rotation_from_rpy(
        {random.uniform(at, -0.6, 0.6), random.uniform(at + 1, -0.6, 0.6), random.uniform(at + 2, -0.4, 0.4)});
    X.translation() = Eigen::Vector3d(random.uniform(at + 3, -0.2, 0.25), random.uniform(at + 4, -0.17, 0.17),
                                      random.uniform(at + 5, 0.3, 0.75));
    X = X * Eigen::Translation3d(-4 * kBoard.square_m, -2.5 * kBoard.square_m, 0);
    const double bend = bend_m * random.uniform(at + 6, -1, 1);
    BoardPair pair;
    bool inside = true;
    const auto seen = [&](const CameraModel& camera, const Eigen::Vector3d& p_C, Corners& corners) {
      if (!(p_C.z() > 0.15)) {
        inside = false;
        return;
      }
      const Eigen::Vector2d pixel = camera.project(p_C);
      inside = inside && pixel.x() > 10 && pixel.y() > 10 && pixel.x() < 630 && pixel.y() < 470;
      corners.emplace_back(static_cast<float>(pixel.x() + sigma_px * gaussian(random, counter)),
                           static_cast<float>(pixel.y() + sigma_px * gaussian(random, counter)));
    };
    for (const cv::Point3f& corner : kBoard.corners()) {
      const double u = corner.x / kBoard.square_m / 4 - 1;
      const Eigen::Vector3d p_L = X * Eigen::Vector3d(corner.x, corner.y, bend * (1 - u * u));
      seen(rig.left, p_L, pair.left);
      seen(rig.right, rig.X_RL * p_L, pair.right);
    }
    if (inside) pairs.push_back(pair);
  }
  return pairs;
}

/// The position that a calibration gives to what the true cameras see at `p_L`, and what it claims.
struct Located {
  Eigen::Vector3d error;
  Eigen::Matrix3d by_rig, by_noise;
};

Located located(const StereoRig& rig, const StereoRig& truth, const Eigen::Vector3d& p_L, double noise_px,
                const CounterRandom& random, uint64_t& counter) {
  const auto seen = [&](const CameraModel& said, const CameraModel& true_camera, const Eigen::Vector3d& p_C) {
    Eigen::Vector2d pixel = true_camera.project(p_C);
    pixel += noise_px * Eigen::Vector2d(gaussian(random, counter), gaussian(random, counter));
    return vision::RayMeasurement{said.ray(pixel), vision::ray_covariance(said, std::max(noise_px, 0.01))};
  };
  const auto point =
      vision::triangulate(rig, seen(rig.left, truth.left, p_L), seen(rig.right, truth.right, truth.X_RL * p_L));
  if (!point) throw std::runtime_error("no position");
  return {point->p_W - p_L, covariance_by_rig_errors(rig, p_L), point->covariance};
}

/// The common rotation of all errors about the left camera: an error of the camera pose, not of the rig.
Eigen::Vector3d common_rotation(const std::vector<Eigen::Vector3d>& positions, const std::vector<Located>& all) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (size_t k = 0; k < all.size(); ++k) {
    const Eigen::Vector3d d = positions[k].normalized();  // of the direction: d' = d + w x d
    const Eigen::Vector3d turned = (positions[k] + all[k].error).normalized() - d;
    normal += Eigen::Matrix3d::Identity() - d * d.transpose();
    right += d.cross(turned);
  }
  return normal.ldlt().solve(right);
}

const std::vector<Eigen::Vector3d> kPositions{
    {0, 0, 0.35},      {0.1, 0.05, 0.4}, {-0.12, -0.1, 0.45}, {0, 0, 0.7},       {0.25, -0.15, 0.7},
    {-0.2, 0.18, 0.7}, {0, 0, 1.2},      {0.4, 0.25, 1.2},    {-0.4, -0.2, 1.5}, {0, 0, 2}};

/// Means over calibrations and positions.
struct Honesty {
  double along = 0;  ///< squared error along the viewing ray, without noise of the images, over its variance
  double nees = 0;   ///< of positions with noise, per dimension
  double view_factor = 0;
};

Honesty honesty(int calibrations, double sigma_px, double bend_m, Lens lens, size_t views) {
  const StereoRig truth = true_rig();
  const double weight = 1.0 / (calibrations * static_cast<double>(kPositions.size()));
  Honesty result;
  for (int k = 0; k < calibrations; ++k) {
    const std::vector<BoardPair> pairs = board_pairs(truth, 100 + static_cast<uint64_t>(k), views, sigma_px, bend_m);
    const StereoCalibration calibration = calibrate(pairs, kBoard, {truth.left.width, truth.left.height}, lens, false);
    result.view_factor += errors_of(calibration, kBoard, lens).view_factor / calibrations;
    const CounterRandom random(7, static_cast<uint64_t>(k));
    uint64_t counter = 0;
    for (const double noise_px : {0.0, 0.1}) {
      std::vector<Located> all;
      for (const Eigen::Vector3d& p : kPositions)
        all.push_back(located(calibration.rig, truth, p, noise_px, random, counter));
      const Eigen::Vector3d turn = common_rotation(kPositions, all);
      for (size_t i = 0; i < all.size(); ++i) {
        const Eigen::Vector3d along = kPositions[i].normalized(), error = all[i].error - turn.cross(kPositions[i]);
        if (noise_px == 0) {
          result.along += weight * std::pow(error.dot(along), 2) / along.dot(all[i].by_rig * along);
        } else {
          const Eigen::Matrix3d both = all[i].by_rig + all[i].by_noise;
          result.nees += weight * error.dot(both.ldlt().solve(error)) / 3;
        }
      }
    }
  }
  std::printf("noise %.2f px, bend %.1f mm: along the viewing ray %.2f, NEES/3 %.2f, view factor %.2f\n", sigma_px,
              1e3 * bend_m, result.along, result.nees, result.view_factor);
  return result;
}

TEST(CalibrationErrors, AreHonestForIndependentCorners) {
  // The squared error along the viewing ray, in variances, has one degree of freedom at each position, and all
  // positions share few errors: the mean over 30 calibrations is between that of chi^2 with 30 degrees of freedom, 0.56
  // to 1.57 for 95 %, and a narrower one.
  const Honesty result = honesty(30, 0.15, 0, Lens::kRadtan, 12);
  EXPECT_GT(result.along, 0.56);
  EXPECT_LT(result.along, 1.57);
  EXPECT_GT(result.nees, 0.56);
  EXPECT_LT(result.nees, 1.57);
  EXPECT_LT(result.view_factor, 1.6) << "nothing contradicts independence";
}

TEST(CalibrationErrors, GrowWithErrorsThatTheCornersOfAViewShare) {
  // Boards that are bent by up to a millimetre, each time otherwise: errors of positions are four times what
  // independent corners explain. A dozen views tell this factor roughly.
  const Honesty result = honesty(10, 0.1, 1e-3, Lens::kRadtan, 12);
  EXPECT_GT(result.view_factor, 4);
  EXPECT_LT(result.nees, 4);
  EXPECT_LT(result.along, 4);
}

TEST(CalibrationErrors, OfTwoHalvesOfRealPhotographsExplainTheirDifference) {
  const std::string folder = "/usr/share/doc/opencv-doc/examples/data/";
  if (!std::filesystem::exists(folder + "left01.jpg")) GTEST_SKIP() << "Debian's opencv-doc is not installed";
  const BoardImages images = find_boards(folder + "left[01]?.jpg", folder + "right[01]?.jpg", kBoard, [](double) {});
  ASSERT_EQ(images.pairs.size(), 13U);
  const StereoRig all = calibrate(images.pairs, kBoard, images.size, Lens::kRadtan, false).rig;
  const CounterRandom random(5);
  constexpr int kSplits = 8;
  double sum = 0;
  for (uint64_t split = 0; split < kSplits; ++split) {
    std::vector<BoardPair> shuffled = images.pairs;
    for (size_t k = shuffled.size() - 1; k > 0; --k)
      std::swap(shuffled[k], shuffled[random.bits(100 * split + k) % (k + 1)]);
    const std::vector<BoardPair> first(shuffled.begin(), shuffled.begin() + 6),
        second(shuffled.begin() + 6, shuffled.end());
    const StereoRig a = calibrate(first, kBoard, images.size, Lens::kRadtan, false).rig,
                    b = calibrate(second, kBoard, images.size, Lens::kRadtan, false).rig;
    std::printf("split %d:", static_cast<int>(split));
    for (const Eigen::Vector3d& p : kPositions) {
      uint64_t unused = 0;
      const Located of_a = located(a, all, p, 0, random, unused), of_b = located(b, all, p, 0, random, unused);
      const Eigen::Vector3d along = p.normalized();
      const double apart = (of_a.error - of_b.error).dot(along);
      const double variance = along.dot((of_a.by_rig + of_b.by_rig) * along);
      sum += apart * apart / variance / (kSplits * static_cast<double>(kPositions.size()));
      std::printf(" %.2f", apart / std::sqrt(variance));
    }
    std::printf("\n");
  }
  std::printf("two halves: squared difference over variance %.2f; all pairs: %.2f, %.2f, %.2f mm at 0.5, 1, 2 m\n", sum,
              1e3 * axial_sigma_m(all, 0.5), 1e3 * axial_sigma_m(all, 1), 1e3 * axial_sigma_m(all, 2));
  EXPECT_LT(sum, 4);
  EXPECT_GT(sum, 0.2);
}

}  // namespace
}  // namespace multireach
