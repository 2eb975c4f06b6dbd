#pragma once

#include <Eigen/Core>
#include <span>

#include "vision/contour/contour_cone.hpp"
#include "vision/contour/contour_edgel.hpp"

namespace multireach::vision {

/// How far an object moved in the image during the exposure, from the blur of its edges.
struct MotionBlur {
  double variance = 0;          ///< of the blur along the motion beyond that across it, px^2
  Eigen::Vector2d along{0, 0};  ///< direction of the motion, a unit vector of either sign; zero without motion
  double length_px() const;     ///< of a motion of constant speed
};

/// Motion blurs the edges that it crosses, and not those along it: the variance of the blur across an edge with normal
/// m is m^T B m, fitted to the edges that support the contour (points of weight > 0), of
/// which measure_blur() was called before.
[[nodiscard]] MotionBlur motion_blur_of(std::span<const ContourEdgel> edgels, std::span<const ContourPoint> points);

}  // namespace multireach::vision
