#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "numeric/rows.hpp"

namespace multireach::vision {

/// The colour of a sphere's surface where its normal is known.
struct SurfaceColour {
  static constexpr int kTerms = 9;
  static constexpr int kNumbers = kTerms + 3;
  /// The terms of the normal (Shading), then blue, green and red, grey levels; the rest, which fills SIMD lanes, is 0.
  alignas(Row) std::array<double, 2 * kRowLanes> numbers{};
  static_assert(kNumbers <= 2 * kRowLanes);

  Eigen::Map<const Eigen::Matrix<double, kTerms, 1>> terms() const {
    return Eigen::Map<const Eigen::Matrix<double, kTerms, 1>>(numbers.data());
  }
  Eigen::Vector3d bgr() const { return {numbers[kTerms], numbers[kTerms + 1], numbers[kTerms + 2]}; }
};

/// Shading model: the object's colour as second-order polynomials of the surface normal, fitted to pixels inside the
/// contour. They represent any distant light on a matt surface to about 1 % (Ramamoorthi & Hanrahan, SIGGRAPH 2001).
class Shading {
 public:
  static constexpr int kTerms = SurfaceColour::kTerms;
  /// Of a unit normal (x, y, z) in the camera's axes: 1, x, y, z, xy, xz, yz, x^2 - y^2, 3 z^2 - 1.
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  using Matrix = Eigen::Matrix<double, kTerms, kTerms>;

  void clear();
  /// Fits the model to surface points by ridge regression: terms that few points determine stay small.
  void fit(std::span<const SurfaceColour> points);
  bool known() const { return known_; }
  /// The colour for a sum of terms; zero before `fit`.
  Eigen::Vector3d colour(const Terms& terms) const { return terms_.transpose().lazyProduct(terms); }
  /// The coefficients of a channel, one for each term.
  const double* coefficients(int channel) const { return terms_.col(channel).data(); }
  /// Variance of colour(terms) in each channel, for points whose colours have variance 1.
  double variance(const Terms& terms) const { return terms.dot(covariance_.lazyProduct(terms)); }
  /// Covariance of each channel's coefficients, likewise for variance 1.
  const Matrix& covariance() const { return covariance_; }

 private:
  Matrix covariance_;
  Eigen::Matrix<double, kTerms, 3> terms_;
  bool known_ = false;
};

}  // namespace multireach::vision
