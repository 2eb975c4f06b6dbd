#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <span>

#include "imaging/lens.hpp"

namespace multireach::vision {

// The outline of a sphere is a circular cone of directions about the direction c to its centre: a unit direction e
// belongs to it when e . c = cos a, with the angular radius a, sin a = r / distance. With n = c / cos a this is
// e . n = 1: linear in n, exact wherever in the image the sphere is and whatever its radius.

/// The outline of a sphere as a camera at the origin sees it.
struct OutlineCone {
  Eigen::Vector3d n;  ///< c / cos a, of length > 1

  /// The direction (x/z, y/z) to the sphere's centre.
  Eigen::Vector2d ray() const { return n.hnormalized(); }
  /// Of the angular radius: the sphere's radius over its centre's distance.
  double sine() const;
  /// Derivative of (x/z, y/z, sine) with respect to n.
  Eigen::Matrix3d jacobian() const;
};

/// Number of corners of an outline's polygon.
constexpr int kOutlineCorners = 64;
using OutlinePolygon = std::array<Eigen::Vector2d, kOutlineCorners>;

/// Points of the cone's image in pixels, at equal angles about its axis, each scaled towards the axis by `scale`.
/// Nothing when a part of the cone is not in front of the camera.
std::optional<OutlinePolygon> polygon_of(const OutlineCone& cone, const CameraModel& camera, double scale = 1);

/// A place on an outline: its direction, and how sure it is.
struct OutlinePoint {
  enum class Along {
    kRow,
    kColumn,
    kNormal
  };                    ///< the direction in which the place was measured; normal to the outline
  Eigen::Vector2d ray;  ///< (x/z, y/z)
  Along along = Along::kNormal;
  double sigma_px = 1;     ///< standard deviation along that direction
  double weight = 1;       ///< set by the fit: 0 for a point that is not of the cone, 1 for one that fits
  double residual_px = 0;  ///< set by the fit: distance from the cone along that direction
  /// Set by the fit: how n changes when the point moves by 1 px along that direction is the fit's covariance times
  /// this.
  Eigen::Vector3d pull{0, 0, 0};
};

/// How a robust fit is done.
struct RobustFit {
  int trials = 48;              ///< cones through three points that are tried; 0 when the start is good
  double gate_px = 1.0;         ///< a point votes for a tried cone within this distance
  double largest_px = 1.5;      ///< a point further off than this has no part in the result
  double tuning = 4.685;        ///< of Tukey's biweight, in units of the robust scale
  double smallest_share = 0.3;  ///< of the points that must vote for the best cone
};

struct ConeFit {
  OutlineCone cone;
  Eigen::Matrix3d covariance;  ///< of n, for errors of the points' sigma_px
  Eigen::Matrix3d geometry;    ///< covariance of n for one point of 1 px that stands for all: that of errors they share
  double points = 0;           ///< sum of the weights
  double scale = 1;            ///< robust standard deviation of residual / sigma
  double spread = 1;  ///< by what the covariance is to be multiplied if the residuals' size is believed instead
};

/// The cone nearest to the points: the best of cones through three of them (random sample consensus with a fixed seed;
/// Fischler & Bolles, CACM 1981), then least squares with Tukey's weights. With `trials` = 0 it starts from `start`.
/// `d_ray_d_pixel`: the lens near the points. Nothing when too few points agree. At most kMostOutlinePoints are used.
std::optional<ConeFit> fit_cone(std::span<OutlinePoint> points, const Eigen::Matrix2d& d_ray_d_pixel,
                                const RobustFit& options, const OutlineCone* start = nullptr);
constexpr int kMostOutlinePoints = 320;

}  // namespace multireach::vision
