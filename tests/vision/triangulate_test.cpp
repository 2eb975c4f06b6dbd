#include "vision/stereo/triangulate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "numeric/gaussian.hpp"

namespace multireach::vision {
namespace {

StereoRig rig() {
  StereoRig rig;
  rig.left = {.width = 640, .height = 480, .fx = 500, .fy = 502, .cx = 320, .cy = 240, .distortion = {}};
  rig.right = rig.left;
  rig.X_RL = Eigen::Isometry3d::Identity();
  rig.X_RL.linear() = Eigen::AngleAxisd(0.02, Eigen::Vector3d(0.2, 1, 0.1).normalized()).toRotationMatrix();
  rig.X_RL.translation() = Eigen::Vector3d(-0.06, 0.001, 0.002);
  rig.X_WL = Eigen::Isometry3d::Identity();
  rig.X_WL.linear() = Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -1, 0.3).normalized()).toRotationMatrix();
  rig.X_WL.translation() = Eigen::Vector3d(0.1, -0.2, 0.5);
  return rig;
}

Eigen::Vector3d random_point(const CounterRandom& random, uint64_t k) {
  return {random.uniform(3 * k, -0.2, 0.2), random.uniform(3 * k + 1, -0.2, 0.2), random.uniform(3 * k + 2, 0.3, 2)};
}

RayMeasurement seen(const CameraModel& camera, const Eigen::Vector3d& p_C, double sigma_px) {
  return {p_C.hnormalized(), ray_covariance(camera, sigma_px)};
}

TEST(Triangulate, IsExactWithoutNoise) {
  const StereoRig r = rig();
  const CounterRandom random(1);
  for (uint64_t k = 0; k < 200; ++k) {
    const Eigen::Vector3d p_L = random_point(random, k), p_R = r.X_RL * p_L;
    const auto point = triangulate(r, seen(r.left, p_L, 0.1), seen(r.right, p_R, 0.1));
    ASSERT_TRUE(point);
    EXPECT_LT((point->p_W - r.X_WL * p_L).norm(), 1e-10);
    EXPECT_NEAR(point->depth_left_m, p_L.z(), 1e-10);
    EXPECT_NEAR(point->depth_right_m, p_R.z(), 1e-10);
    EXPECT_LT(point->epipolar_error_px, 1e-7);
  }
}

TEST(Triangulate, DepthUncertaintyIsThatOfTheDisparity) {
  StereoRig r = rig();
  r.X_RL = Eigen::Isometry3d::Identity();
  r.X_RL.translation() = Eigen::Vector3d(-0.06, 0, 0);
  r.X_WL = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d p(0, 0, 0.5);
  const auto point = triangulate(r, seen(r.left, p, 1), seen(r.right, r.X_RL * p, 1));
  // sigma_Z = Z^2 / (f B) * sigma_disparity, with sigma_disparity = sqrt(2) px: 8.3 mm per pixel of disparity.
  EXPECT_NEAR(std::sqrt(point->covariance(2, 2)), std::sqrt(2.0) * 0.25 / (500 * 0.06), 2e-4);
}

TEST(Triangulate, CovarianceIsHonest) {
  // The normalised squared error has mean 3 if the covariance describes the errors correctly.
  const StereoRig r = rig();
  const CounterRandom random(2);
  constexpr double kSigma = 0.3;
  constexpr int kCases = 5000;
  double sum = 0;
  for (uint64_t k = 0; k < kCases; ++k) {
    const Eigen::Vector3d p_L = random_point(random, k), p_R = r.X_RL * p_L;
    const auto normal = [&](uint64_t i) {
      uint64_t counter = 1000000 + 2 * (10 * k + i);
      return gaussian(random, counter);
    };
    const Eigen::Vector2d focal(r.left.fx, r.left.fy);
    const Eigen::Vector2d left =
        p_L.hnormalized() + kSigma * Eigen::Vector2d(normal(0), normal(1)).cwiseQuotient(focal);
    const Eigen::Vector2d right =
        p_R.hnormalized() + kSigma * Eigen::Vector2d(normal(2), normal(3)).cwiseQuotient(focal);
    const auto point = triangulate(r, {left, ray_covariance(r.left, kSigma)}, {right, ray_covariance(r.right, kSigma)});
    ASSERT_TRUE(point);
    const Eigen::Vector3d error = point->p_W - r.X_WL * p_L;
    sum += error.dot(point->covariance.ldlt().solve(error));
  }
  EXPECT_NEAR(sum / kCases / 3, 1, 0.04);
}

TEST(Triangulate, WhatBothImagesShareMovesASphereAcrossTheLineOfSightOnly) {
  // Midway before two parallel cameras: depth is B / (x_L - x_R), the place across it Z (x_L + x_R) / 2. With an
  // error c that both images share and errors of their own o: sigma_Z = Z^2 / B sqrt(2) o, sigma_X^2 = Z^2 (o^2 / 2 +
  // c^2).
  StereoRig r = rig();
  r.X_RL = r.X_WL = Eigen::Isometry3d::Identity();
  constexpr double kBaseline = 0.06, kDepth = 0.5, kOwn = 2e-4, kShared = 5e-4, kRadius = 0.02;
  r.X_RL.translation() = Eigen::Vector3d(-kBaseline, 0, 0);
  const Eigen::Vector3d p(kBaseline / 2, 0, kDepth);
  const auto sphere_at = [&](const Eigen::Vector3d& p_C) {
    SphereMeasurement sphere;
    sphere.value << p_C.hnormalized(), kRadius / p_C.norm();
    sphere.shared(0, kLight) = kShared;
    constexpr double kSizeUnknown = 0.1;  // the radius is free: only the sizes' ratio could say something
    sphere.covariance = Eigen::Vector3d(kOwn * kOwn, kOwn * kOwn, kSizeUnknown * kSizeUnknown).asDiagonal();
    sphere.covariance += sphere.shared * sphere.shared.transpose();
    return sphere;
  };
  const auto point = triangulate_sphere(r, sphere_at(p), sphere_at(r.X_RL * p), std::nullopt);
  ASSERT_TRUE(point);
  EXPECT_LT((point->p_W - p).norm(), 1e-9);
  const Eigen::Vector3d sigma = point->covariance.diagonal().cwiseSqrt();
  EXPECT_NEAR(sigma.z() / (kDepth * kDepth / kBaseline * std::sqrt(2.0) * kOwn), 1, 1e-3);
  EXPECT_NEAR(sigma.x() / (kDepth * std::sqrt(kOwn * kOwn / 2 + kShared * kShared)), 1, 1e-3);
  EXPECT_NEAR(sigma.y() / (kDepth * kOwn / std::sqrt(2.0)), 1, 1e-3);
}

TEST(Triangulate, CovarianceIsHonestForErrorsThatBothImagesShare) {
  const StereoRig r = rig();
  const CounterRandom random(3);
  constexpr double kOwn = 2e-4, kOwnSize = 1e-4;
  constexpr int kCases = 5000;
  double sum = 0;
  for (uint64_t k = 0; k < kCases; ++k) {
    const auto normal = [&](uint64_t i) {
      uint64_t counter = 1000000 + 2 * (9 * k + i);
      return gaussian(random, counter);
    };
    const Eigen::Vector3d p_L = random_point(random, k), p_R = r.X_RL * p_L;
    constexpr double kRadius = 0.02;
    const Eigen::Vector4d of_both(normal(0), normal(1), normal(8), normal(9));  // one value of each cause
    const auto measured = [&](const Eigen::Vector3d& p_C, double strength, uint64_t first) {
      SphereMeasurement sphere;
      sphere.shared.col(kLight) << 4e-4 * strength, -2e-4, 0;
      sphere.shared.col(kOccluded) << 3e-4, 5e-4, 1e-4 * strength;
      sphere.shared.col(kShape) << -5e-4 * strength, 2e-4, 0;
      sphere.shared.col(kGammaCurve) << 1e-4, -3e-4 * strength, -1e-4;
      const Eigen::Vector3d own(kOwn, kOwn, kOwnSize);
      sphere.covariance = own.cwiseAbs2().asDiagonal();
      sphere.covariance += sphere.shared * sphere.shared.transpose();
      sphere.value << p_C.hnormalized(), kRadius / p_C.norm();
      sphere.value += sphere.shared * of_both +
                      own.cwiseProduct(Eigen::Vector3d(normal(first), normal(first + 1), normal(first + 2)));
      return sphere;
    };
    const auto point = triangulate_sphere(r, measured(p_L, 1, 2), measured(p_R, 1.2, 5), std::nullopt);
    ASSERT_TRUE(point);
    const Eigen::Vector3d error = point->p_W - r.X_WL * p_L;
    sum += error.dot(point->covariance.ldlt().solve(error));
  }
  // The mean of chi^2 with three degrees of freedom over these cases scatters by sqrt(6 / 5000) = 0.035: four of them.
  EXPECT_NEAR(sum / kCases / 3, 1, 4 * 0.035 / 3) << "seed 3";
}

TEST(Triangulate, NothingBehindTheCamerasOrForParallelRays) {
  const StereoRig r = rig();
  const Eigen::Vector3d p(0.05, 0, 0.5);
  const Eigen::Vector2d left = p.hnormalized(), right = (r.X_RL * p).hnormalized();
  const Eigen::Matrix2d one = ray_covariance(r.left, 1);
  EXPECT_TRUE(triangulate(r, {left, one}, {right, one}));
  EXPECT_FALSE(triangulate(r, {left, one}, {right + Eigen::Vector2d(0.3, 0), one})) << "the rays part";
  const Eigen::Vector3d parallel = r.X_RL.linear() * left.homogeneous();
  EXPECT_FALSE(triangulate(r, {left, one}, {parallel.hnormalized(), one}));
}

}  // namespace
}  // namespace multireach::vision
