#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "numeric/rows.hpp"
#include "vision/contour/contour_cone.hpp"

namespace multireach::vision {

/// One number for each point of a contour, in blocks of SIMD lanes.
class PointNumbers {
 public:
  double& operator[](int point) { return rows_[static_cast<size_t>(point / kRowLanes)][point % kRowLanes]; }
  double operator[](int point) const { return rows_[static_cast<size_t>(point / kRowLanes)][point % kRowLanes]; }
  Row& row(int block) { return rows_[static_cast<size_t>(block)]; }
  const Row& row(int block) const { return rows_[static_cast<size_t>(block)]; }

 private:
  static_assert(kMaxContourPoints % kRowLanes == 0);
  std::array<Row, kMaxContourPoints / kRowLanes> rows_;
};

/// A point's unit direction e and its derivative (per pixel) along the direction of measurement. For a point measured
/// along the contour's normal: the derivatives along rows and along columns.
struct DirectionRows {
  std::array<PointNumbers, 3> e, step, other_step;
  PointNumbers normal;  ///< 1 for a point that is measured along the contour's normal, else 0
};

/// The unit directions of the points of a contour, and how far cones are from them. Computes several points at a time,
/// in SIMD lanes; the results do not depend on the instruction set.
class ContourDirections {
 public:
  /// The directions of every `stride`-th point, at most kMaxContourPoints. `d_ray_d_pixel` is the inverse Jacobian of
  /// the lens near the points.
  void set(std::span<const ContourPoint> points, const Eigen::Matrix2d& d_ray_d_pixel, int stride = 1);
  int count() const { return count_; }
  Eigen::Vector3d direction(int point) const { return {rows_.e[0][point], rows_.e[1][point], rows_.e[2][point]}; }

  /// Of each point: the derivative of e . n per pixel, along the direction of measurement, and the distance of the cone
  /// n along it, pixels.
  void compare(const Eigen::Vector3d& n, PointNumbers& slopes, PointNumbers& distances_px) const;
  /// Sum over the points of the squared distance of the cone n, in units of `gate_px` and at most 1 for each; stops
  /// soon after it exceeds `most`.
  double cost(const Eigen::Vector3d& n, double gate_px, double most) const;

 private:
  DirectionRows rows_;
  int count_ = 0;
};

/// The points' parts in a step of iteratively reweighted least squares.
struct PointWeights {
  PointNumbers weight;          ///< Tukey's biweight, zero beyond `reach` sigmas and `largest_px`
  PointNumbers by_sigma;        ///< weight / (slope sigma)^2
  PointNumbers by_slope;        ///< weight / slope^2
  PointNumbers psi2;            ///< the square of Tukey's psi
  PointNumbers psi_derivative;  ///< the derivative of psi, where the weight is not 0

  /// From the points' distances from a cone, the slopes of ContourDirections::compare() and the standard deviations of
  /// the points. These must be positive in all lanes of the last block, also in those without a point.
  void set(int count, const PointNumbers& residuals_px, const PointNumbers& sigmas_px, const PointNumbers& slopes,
           double reach, double largest_px);
};

}  // namespace multireach::vision
