#pragma once

#include <Eigen/Geometry>
#include <stdexcept>

#include "imaging/camera_model.hpp"
#include "imaging/side.hpp"

namespace multireach {

/// How uncertain a stereo calibration is: the covariance of the errors that move triangulated positions in the left
/// camera's frame. An error of the whole rig's orientation is none of them: the camera pose X_WL takes it up.
struct RigErrors {
  enum Error {
    kFocalLength,  ///< of all focal lengths, relative
    kBaseline,     ///< of the distance between the cameras, relative
    kRotationX,    ///< rotation of the right camera about its own axes x, y, z, rad
    kRotationY,
    kRotationZ,
    kCount
  };
  Eigen::Matrix<double, kCount, kCount> covariance =
      Eigen::Matrix<double, kCount, kCount>::Zero();  ///< zero: not known

  bool known() const { return !covariance.isZero(0); }
};

/// Two cameras with fixed poses relative to each other and to the robot's base.
struct StereoRig {
  CameraModel left, right;
  Eigen::Isometry3d X_RL;  ///< maps left-camera to right-camera coordinates (R and T of OpenCV's stereo calibration)
  Eigen::Isometry3d X_WL;  ///< maps left-camera coordinates to the robot's base frame W
  RigErrors errors{};      ///< of the calibration

  double baseline_m() const { return X_RL.translation().norm(); }
  const CameraModel& camera(Side side) const { return side == Side::kLeft ? left : right; }
};

/// Whether two rigs have the same cameras at the same poses.
inline bool same_cameras(const StereoRig& a, const StereoRig& b) {
  return a.left == b.left && a.right == b.right && a.X_RL.isApprox(b.X_RL, 0) && a.X_WL.isApprox(b.X_WL, 0);
}

/// Two equal cameras without distortion side by side, looking as the left one does, whose frame is also W: of rectified
/// images. `width`, `height`, `focal`: pixels. The optical axes pass through the middle of the images.
inline StereoRig parallel_rig(int width, int height, double focal, double baseline_m) {
  StereoRig rig;
  rig.left = {.width = width,
              .height = height,
              .fx = focal,
              .fy = focal,
              .cx = 0.5 * (width - 1),
              .cy = 0.5 * (height - 1),
              .distortion = {}};
  rig.right = rig.left;
  rig.X_RL = rig.X_WL = Eigen::Isometry3d::Identity();
  rig.X_RL.translation().x() = -baseline_m;
  return rig;
}

/// Throws std::invalid_argument when no position can be computed from the images of such cameras.
inline void require_usable(const StereoRig& rig) {
  const auto require = [](bool sensible, const char* sentence) {
    if (!sensible) throw std::invalid_argument(sentence);
  };
  for (const CameraModel* camera : {&rig.left, &rig.right}) {
    require(camera->width > 0 && camera->height > 0, "a camera's image size must be positive");
    require(camera->fx > 0 && camera->fy > 0, "a camera's focal lengths must be positive");
  }
  require(rig.baseline_m() > 1e-6, "the two cameras are at the same position: there is no baseline");
}

}  // namespace multireach
