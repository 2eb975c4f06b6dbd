// The covariance that a calibration's errors cause, against positions triangulated with wrong calibrations.
#include "imaging/rig_errors.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "imaging/lens.hpp"
#include "vision/stereo/triangulate.hpp"

namespace multireach {
namespace {

StereoRig rig() {
  StereoRig rig;
  rig.left = {.width = 640,
              .height = 480,
              .fx = 500,
              .fy = 504,
              .cx = 325,
              .cy = 236,
              .distortion = {-0.25, 0.08, 0.001, -0.002}};
  rig.right = {.width = 640,
               .height = 480,
               .fx = 495,
               .fy = 498,
               .cx = 312,
               .cy = 243,
               .distortion = {-0.22, 0.05, -0.001, 0.001}};
  rig.X_RL = Eigen::Isometry3d::Identity();
  rig.X_RL.linear() = Eigen::AngleAxisd(0.08, Eigen::Vector3d(0.2, 1, 0.1).normalized()).toRotationMatrix();
  rig.X_RL.translation() = Eigen::Vector3d(-0.09, 0.002, 0.006);
  rig.X_WL = Eigen::Isometry3d::Identity();
  rig.X_WL.linear() = Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -1, 0.3).normalized()).toRotationMatrix();
  rig.X_WL.translation() = Eigen::Vector3d(0.1, -0.2, 0.5);
  return rig;
}

/// The rig with wrong focal lengths, baseline and rotation.
StereoRig wrong(StereoRig rig, const Eigen::Matrix<double, RigErrors::kCount, 1>& errors) {
  for (CameraModel* camera : {&rig.left, &rig.right}) {
    camera->fx *= 1 + errors[RigErrors::kFocalLength];
    camera->fy *= 1 + errors[RigErrors::kFocalLength];
  }
  rig.X_RL.translation() *= 1 + errors[RigErrors::kBaseline];
  const Eigen::Vector3d turn = errors.tail<3>();
  if (turn.norm() > 0) rig.X_RL = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * rig.X_RL;
  return rig;
}

/// The position that a rig gives to the images of `p_W` in the cameras of `truth`.
Eigen::Vector3d located(const StereoRig& rig, const StereoRig& truth, const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p_L = truth.X_WL.inverse() * p_W;
  const auto seen = [](const CameraModel& said, const CameraModel& true_camera, const Eigen::Vector3d& p_C) {
    const Eigen::Vector2d ray = said.ray(true_camera.project(p_C));
    const Eigen::Matrix2d inverse = image_of(said, ray).d_pixel_d_ray.inverse();  // errors of a pixel, as a ray
    return vision::RayMeasurement{ray, inverse * inverse.transpose()};
  };
  const auto point =
      vision::triangulate(rig, seen(rig.left, truth.left, p_L), seen(rig.right, truth.right, truth.X_RL * p_L));
  return point ? point->p_W : Eigen::Vector3d::Constant(1e9);
}

const std::vector<Eigen::Vector3d> kPositions{{0, 0, 0.3},       {0.05, 0.02, 0.5},  {-0.2, 0.1, 0.5},
                                              {0.25, -0.2, 0.6}, {-0.3, -0.25, 0.8}, {0.1, 0.3, 1.2},
                                              {0.4, 0.1, 2},     {-1, 0.6, 3}};

TEST(RigErrors, MovePositionsAsTriangulationWithAWrongRigDoes) {
  const StereoRig truth = rig();
  const Eigen::Matrix3d R_WL = truth.X_WL.linear();
  for (const Eigen::Vector3d& p_L : kPositions) {
    const auto moved = d_position_d_errors(truth, p_L);
    for (int k = 0; k < RigErrors::kCount; ++k) {
      constexpr double kStep = 1e-5;
      Eigen::Matrix<double, RigErrors::kCount, 1> errors = Eigen::Matrix<double, RigErrors::kCount, 1>::Zero();
      errors[k] = kStep;
      const Eigen::Vector3d above = located(wrong(truth, errors), truth, truth.X_WL * p_L);
      const Eigen::Vector3d below = located(wrong(truth, -errors), truth, truth.X_WL * p_L);
      const Eigen::Vector3d difference = R_WL.transpose() * (above - below) / (2 * kStep);
      EXPECT_LT((difference - moved.col(k)).norm(), 1e-4 * moved.col(k).norm() + 1e-7)
          << "error " << k << " at " << p_L.transpose() << ": " << difference.transpose() << " instead of "
          << moved.col(k).transpose();
    }
  }
}

TEST(RigErrors, OfABaselineScalePositionsAlongTheirDistance) {
  StereoRig r = parallel_rig(640, 480, 500, 0.1);
  r.errors.covariance(RigErrors::kBaseline, RigErrors::kBaseline) = 1e-4;  // 1 %
  const Eigen::Vector3d p(0.1, -0.2, 0.7);
  EXPECT_TRUE(covariance_by_rig_errors(r, p).isApprox(1e-4 * p * p.transpose(), 1e-9));
  // Angles between the cameras: z^2 / baseline, on the axis.
  r.errors.covariance.setZero();
  r.errors.covariance(RigErrors::kRotationY, RigErrors::kRotationY) = 1e-6;
  EXPECT_NEAR(std::sqrt(covariance_by_rig_errors(r, {0.05, 0, 2})(2, 2)), 1e-3 * 4 / 0.1, 2e-4);
}

TEST(RigErrors, ChangeTheMeasuredSizeOfAThing) {
  // A radius is the angle that it covers, which a longer focal length makes smaller, times the distance.
  const StereoRig truth = rig();
  constexpr double kStep = 1e-5;
  for (const Eigen::Vector3d& p_L : kPositions) {
    for (int k = 0; k < RigErrors::kCount; ++k) {
      StereoRig said = truth;
      said.errors.covariance(k, k) = kStep * kStep;
      Eigen::Matrix<double, RigErrors::kCount, 1> errors = Eigen::Matrix<double, RigErrors::kCount, 1>::Zero();
      errors[k] = kStep;
      const Eigen::Vector3d p_W = truth.X_WL * p_L;
      const double distance = (truth.X_WL.inverse() * located(wrong(truth, errors), truth, p_W)).norm();
      const double angle = k == RigErrors::kFocalLength ? 1 / (1 + kStep) : 1;
      const double expected = std::abs(angle * distance / p_L.norm() - 1);
      EXPECT_NEAR(std::sqrt(size_variance_by_rig_errors(said, p_W)), expected, 1e-2 * (expected + kStep))
          << k << " at " << p_L.transpose();
    }
  }
}

TEST(RigErrors, OfAPositionByOneImageAreThoseOfItsCamera) {
  StereoRig r = rig();
  const Eigen::Vector3d p_L(0.1, -0.2, 0.8), p_W = r.X_WL * p_L, p_R = r.X_RL * p_L;
  const auto moved = [&](Side side, RigErrors::Error error) {
    r.errors.covariance.setZero();
    r.errors.covariance(error, error) = 1e-4;
    return covariance_by_rig_errors(r, side, p_W);
  };
  const Eigen::Vector3d axis = r.X_WL.linear().col(2);
  EXPECT_TRUE(moved(Side::kLeft, RigErrors::kFocalLength).isApprox(1e-4 * 0.64 * axis * axis.transpose(), 1e-9));
  EXPECT_TRUE(moved(Side::kLeft, RigErrors::kBaseline).isZero(0));
  EXPECT_TRUE(moved(Side::kLeft, RigErrors::kRotationY).isZero(0));
  EXPECT_NEAR(moved(Side::kRight, RigErrors::kFocalLength).trace(), 1e-4 * p_R.z() * p_R.z(), 1e-12);
  EXPECT_NEAR(moved(Side::kRight, RigErrors::kBaseline).trace(), 1e-4 * r.baseline_m() * r.baseline_m(), 1e-12);
  EXPECT_NEAR(moved(Side::kRight, RigErrors::kRotationY).trace(), 1e-4 * (p_R.x() * p_R.x() + p_R.z() * p_R.z()),
              1e-12);
}

TEST(RigErrors, GiveACovarianceInTheFrameOfTheRobot) {
  StereoRig r = rig();
  const Eigen::Matrix<double, RigErrors::kCount, RigErrors::kCount> any =
      Eigen::Matrix<double, RigErrors::kCount, RigErrors::kCount>::NullaryExpr(
          [](Eigen::Index row, Eigen::Index column) { return 1e-3 * ((3 * row + 5 * column) % 7 - 3.0); });
  r.errors.covariance = any * any.transpose();
  const Eigen::Vector3d p_W = r.X_WL * Eigen::Vector3d(0.1, -0.1, 0.8);
  const Eigen::Matrix3d in_W = covariance_by_rig_errors(r, p_W), R = r.X_WL.linear();
  const Eigen::Vector3d p_L = r.X_WL.inverse() * p_W;
  r.X_WL.setIdentity();
  EXPECT_TRUE(in_W.isApprox(R * covariance_by_rig_errors(r, p_L) * R.transpose(), 1e-9));
}

TEST(RigErrors, AreZeroWhereNothingIsKnownOrSeen) {
  StereoRig r = rig();
  EXPECT_FALSE(r.errors.known());
  EXPECT_TRUE(covariance_by_rig_errors(r, r.X_WL * Eigen::Vector3d(0, 0, 1)).isZero(0));
  r.errors.covariance.setIdentity();
  EXPECT_TRUE(r.errors.known());
  EXPECT_FALSE(covariance_by_rig_errors(r, r.X_WL * Eigen::Vector3d(0, 0, 1)).isZero(0));
  EXPECT_TRUE(covariance_by_rig_errors(r, r.X_WL * Eigen::Vector3d(0, 0, -1)).isZero(0)) << "behind the cameras";
  EXPECT_TRUE(covariance_by_rig_errors(r, r.X_WL * Eigen::Vector3d(0, 0, 0)).isZero(0));
}

}  // namespace
}  // namespace multireach
