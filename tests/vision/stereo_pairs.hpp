#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "vision/stereo/stereo_match.hpp"

/// Contours of balls as a perfect stereo camera would measure them.
namespace multireach::vision::testing {

using Status = StereoMatch::Status;
inline constexpr double kRadius = 0.02;

inline StereoRig rig() {
  StereoRig rig;
  rig.left = {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240, .distortion = {}};
  rig.right = rig.left;
  rig.X_RL = rig.X_WL = Eigen::Isometry3d::Identity();
  rig.X_RL.translation() = Eigen::Vector3d(-0.06, 0, 0);
  rig.X_WL.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  rig.X_WL.translation() = Eigen::Vector3d(0.1, 0.2, 0.3);
  return rig;
}

/// The contour that a perfect camera would measure of a sphere.
inline SphereContour disc_of(const CameraModel& camera, const Eigen::Vector3d& p_C, double radius = kRadius,
                             double sigma_px = 0.03) {
  SphereContour disc;
  disc.kind = SphereContour::Kind::kEdges;
  disc.value << p_C.hnormalized(), radius / p_C.norm();
  disc.covariance = std::pow(sigma_px / camera.fx, 2) * Eigen::Matrix3d::Identity();
  disc.centre_px = camera.project(p_C);
  disc.radius_px = disc.value.z() * camera.fx;
  disc.area = M_PI * disc.radius_px * disc.radius_px;
  disc.visible_fraction = 1;
  return disc;
}

struct Pair {
  SphereContour left, right;
};
inline Pair pair_of(const Eigen::Vector3d& p_L, double radius = kRadius) {
  const StereoRig r = rig();
  return {disc_of(r.left, p_L, radius), disc_of(r.right, r.X_RL * p_L, radius)};
}

inline StereoMatch match_candidates(const std::vector<SphereContour>& left, const std::vector<SphereContour>& right,
                                    const std::optional<Prediction>& prediction = std::nullopt,
                                    const MatchOptions& options = {.radius_m = kRadius}) {
  return vision::match_candidates(rig(), left, right, prediction, options);
}

inline const Eigen::Vector3d kBall(0.03, -0.02, 0.5);

}  // namespace multireach::vision::testing
