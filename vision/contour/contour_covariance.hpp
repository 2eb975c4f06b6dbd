#pragma once

#include <Eigen/Core>
#include <span>

#include "vision/contour/contour_cone.hpp"
#include "vision/contour/contour_edgel.hpp"
#include "vision/contour/motion_blur.hpp"
#include "vision/contour/shared_errors.hpp"

namespace multireach::vision {

/// What a fit of a cone to edges knew and found.
struct ContourEvidence {
  std::span<const ContourEdgel> edgels;  ///< in order along the contour
  std::span<const ContourPoint> points;  ///< with what the fit set
  const ConeFit& fit;
  const Shading& shading;  ///< of the object
  double noise = 0;        ///< standard deviation of a pixel's independent noise, grey levels
  double focal_px = 0;
  Eigen::Matrix2d d_ray_d_pixel;  ///< inverse Jacobian of the lens near the contour
  bool whole = true;              ///< (nearly) all of the contour has edges
  double painted = 0;             ///< share of the contour beside which the surface has another colour than most of it
  bool hues_blurred = false;      ///< the image has subsampled chroma, as measured or known
  bool chroma_known = false;      ///< that is known from the image's encoding
  double colour_blur2 = 0;        ///< variance of the blur across the edges, px^2
  double residual_px = 0;         ///< root mean square of the edges' distances from the contour
  MotionBlur motion;
};

struct ContourCovariance {
  Eigen::Matrix3d covariance;                  ///< of (x/z, y/z, s), including model errors and `shared`
  SharedErrors shared = SharedErrors::Zero();  ///< the errors that the other image of a pair shares
};

/// Covariance of a contour's direction and size: noise and texture of the edges, by the residuals and how neighbours
/// share them, and the errors of the models of light, blur and lens. At least one point has a weight above 0.
[[nodiscard]] ContourCovariance covariance_of(const ContourEvidence& evidence);

}  // namespace multireach::vision
