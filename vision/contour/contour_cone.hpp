#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>

#include "imaging/lens.hpp"

namespace multireach::vision {

// The occluding contour of a sphere is a circular cone of directions about the direction c to its centre: a unit
// direction e lies on it when e . c = cos a, with the angular radius a, sin a = r / distance. With n = c / cos a this
// is e . n = 1: linear in n, and exact for any position in the image and any radius.

/// The occluding-contour cone of a sphere, seen by a camera at the origin.
struct ContourCone {
  Eigen::Vector3d n;  ///< c / cos a, of length > 1

  /// Direction (x/z, y/z) to the sphere's centre.
  Eigen::Vector2d ray() const { return n.hnormalized(); }
  /// Sine of the angular radius: the sphere's radius / distance of its centre.
  double sine() const;
  /// Derivative of (x/z, y/z, sine) with respect to n.
  Eigen::Matrix3d jacobian() const;
};

/// A measured point on a contour: its direction and standard deviation.
struct ContourPoint {
  enum class Along {
    kRow,
    kColumn,
    kNormal
  };                    ///< direction of measurement: along a row, a column or the contour's normal
  Eigen::Vector2d ray;  ///< (x/z, y/z)
  Along along = Along::kNormal;
  double sigma_px = 1;     ///< standard deviation along that direction
  double weight = 1;       ///< set by the fit: from 0 (outlier) to 1 (fits exactly)
  double residual_px = 0;  ///< set by the fit: distance from the cone along that direction
  /// Set by the fit. The fit's covariance times this is the derivative of n with respect to a shift of the point by 1
  /// px along that direction.
  Eigen::Vector3d pull{0, 0, 0};
};

/// Options of the robust fit.
struct RobustFit {
  int trials = 48;              ///< RANSAC trials, each a cone through three points; 0 to refine `start` only
  double gate_px = 1.0;         ///< inlier distance of RANSAC
  double largest_px = 1.5;      ///< points with a larger residual are ignored
  double tuning = 4.685;        ///< tuning constant of Tukey's biweight, in units of the robust scale
  double smallest_share = 0.3;  ///< smallest share of points that must support the best cone
};

struct ConeFit {
  ContourCone cone;
  Eigen::Matrix3d covariance;  ///< of n, for independent errors of the points with their sigma_px
  Eigen::Matrix3d geometry;    ///< covariance of n for one point with 1 px error: for errors that the points share
  double points = 0;           ///< sum of the weights
  double scale = 1;            ///< robust standard deviation of residual / sigma
  double spread = 1;           ///< factor on `covariance` that scales it to the observed residuals
};

/// Fits a cone to the points: RANSAC over cones through three points (fixed seed; Fischler & Bolles, CACM 1981), then
/// least squares with Tukey's weights. With `trials` = 0 it starts from `start` instead. `d_ray_d_pixel` is the inverse
/// Jacobian of the lens near the points. Nothing when too few points agree. Uses at most kMaxContourPoints.
[[nodiscard]] std::optional<ConeFit> fit_cone(std::span<ContourPoint> points, const Eigen::Matrix2d& d_ray_d_pixel,
                                              const RobustFit& options, const ContourCone* start = nullptr);
constexpr int kMaxContourPoints = 320;

}  // namespace multireach::vision
