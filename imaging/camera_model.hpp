#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace multireach {

/// A pinhole camera with OpenCV's rational lens distortion. Pixels have the centre of the first pixel at (0, 0).
struct CameraModel {
  int width = 0, height = 0;              ///< pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
  std::array<double, 8> distortion{};     ///< k1, k2, p1, p2, k3, k4, k5, k6; all zero: no distortion
  /// Grey levels are light to the power of 1 / gamma: 1 where they are proportional to it, about 2.2 for most cameras
  /// (IEC 61966-2-1). Nothing: not known.
  std::optional<double> gamma{};

  /// Focal length of a camera with square pixels that covers the same solid angle, pixels.
  double focal_px() const { return std::sqrt(fx * fy); }
  /// Projects a point `p_C` in front of the camera (z > 0; m, in the camera's frame) to pixels.
  Eigen::Vector2d project(const Eigen::Vector3d& p_C) const;
  /// Undistorted viewing ray (x/z, y/z) of a pixel: the inverse of `project`.
  Eigen::Vector2d ray(const Eigen::Vector2d& pixel) const;
  std::vector<Eigen::Vector2d> rays(const std::vector<Eigen::Vector2d>& pixels) const;

  friend bool operator==(const CameraModel&, const CameraModel&) = default;
};

}  // namespace multireach
