#include "vision/contour/contour_cone.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "numeric/random.hpp"
#include "numeric/trigonometry.hpp"

namespace multireach::vision {
namespace {

/// A point's unit direction e and its derivative (per pixel) along the direction of measurement. For a point measured
/// along the contour's normal: the derivatives along rows and along columns.
struct Direction {
  Eigen::Vector3d e, step, other_step;
  bool normal;

  Direction() = default;
  Direction(const ContourPoint& point, const Eigen::Matrix2d& d_ray_d_pixel)
      : normal(point.along == ContourPoint::Along::kNormal) {
    const double x = point.ray.x(), y = point.ray.y(), inverse = 1 / std::sqrt(x * x + y * y + 1);
    e = Eigen::Vector3d(x, y, 1) * inverse;
    const auto tangent = [&](int axis) -> Eigen::Vector3d {
      const Eigen::Vector3d d(d_ray_d_pixel(0, axis), d_ray_d_pixel(1, axis), 0);
      return (d - e * e.dot(d)) * inverse;
    };
    step = tangent(point.along == ContourPoint::Along::kColumn ? 1 : 0);
    other_step = normal ? tangent(1) : Eigen::Vector3d::Zero();
  }

  /// Derivative of e . n, per pixel, along the direction of measurement.
  double slope(const Eigen::Vector3d& n) const {
    double slope = step.dot(n);
    if (normal) {
      const double other = other_step.dot(n);
      slope = std::sqrt(slope * slope + other * other);
    }
    // Bounded away from 0: the distance is unbounded where the contour is parallel to the direction of measurement.
    constexpr double kSmallest = 1e-9;
    return std::abs(slope) > kSmallest ? slope : std::copysign(kSmallest, slope);
  }
  double distance_px(const Eigen::Vector3d& n) const { return (1 - e.dot(n)) / slope(n); }
};

constexpr double kMissed = 1e-3;     // RANSAC stops below this probability that no trial had three inliers
constexpr double kConverged = 1e-3;  // pixels: least squares stops at a smaller step

bool is_cone(const Eigen::Vector3d& n) {
  constexpr double kWidest = 2;  // 1 / cos 60 degrees
  const double q = n.squaredNorm();
  return n.allFinite() && n.z() > 0 && q > 1 + 1e-10 && q < kWidest * kWidest;
}

}  // namespace

double ContourCone::sine() const {
  return std::sqrt(std::max(0.0, 1 - 1 / n.squaredNorm()));
}

Eigen::Matrix3d ContourCone::jacobian() const {
  const double q = n.squaredNorm();
  Eigen::Matrix3d J;
  J << 1 / n.z(), 0, -n.x() / (n.z() * n.z()), 0, 1 / n.z(), -n.y() / (n.z() * n.z()), 0, 0, 0;
  J.row(2) = n.transpose() / (sine() * q * q);
  return J;
}

namespace {

/// The points' directions, in the points' order.
struct Directions {
  int count = 0;
  std::array<Direction, kMaxContourPoints> of;
};

/// RANSAC: the cone through three points that most of the others support, if enough do.
std::optional<Eigen::Vector3d> best_of_trials(const Directions& directions, const RobustFit& options) {
  const int count = directions.count;
  // A subset of the points scores each candidate cone, to save time.
  const int stride = 1 + (count - 1) / 64, voters = (count + stride - 1) / stride;
  std::optional<Eigen::Vector3d> n;
  double best = voters * (1 - options.smallest_share);
  // Probability that no trial so far had three inliers, given the inlier share of the best cone.
  double missed = 1;
  const CounterRandom random(20081);
  for (int trial = 0; trial < options.trials && missed > kMissed; ++trial) {
    const double good = n ? 1 - best / voters : 0;
    missed *= 1 - good * good * good;
    Eigen::Matrix3d E;
    const auto modulus = static_cast<uint64_t>(count);
    for (int k = 0; k < 3; ++k)
      E.row(k) = directions.of[random.bits(static_cast<uint64_t>(3 * trial + k)) % modulus].e.transpose();
    const double det = E.determinant();
    if (!(std::abs(det) > 1e-12)) continue;
    const Eigen::Vector3d tried = E.inverse() * Eigen::Vector3d::Ones();
    if (!is_cone(tried)) continue;
    double cost = 0;
    for (int i = 0; i < count && cost < best; i += stride) {
      const double z = directions.of[i].distance_px(tried) / options.gate_px;
      cost += std::min(z * z, 1.0);
    }
    if (cost >= best) continue;
    best = cost;
    n = tried;
  }
  return n;
}

using Slopes = std::array<double, kMaxContourPoints>;

/// Sets the points' residuals and their slopes at the cone `n`. Returns the robust standard deviation of residual /
/// sigma of the points near the cone (the others are outliers); nothing when there are too few.
std::optional<double> robust_scale(std::span<ContourPoint> points, const Directions& directions,
                                   const Eigen::Vector3d& n, double largest_px, Slopes& slopes) {
  std::array<double, kMaxContourPoints> sizes;
  int near = 0;
  for (int i = 0; i < directions.count; ++i) {
    slopes[i] = directions.of[i].slope(n);
    points[i].residual_px = (1 - directions.of[i].e.dot(n)) / slopes[i];
    if (std::abs(points[i].residual_px) < largest_px)
      sizes[near++] = std::abs(points[i].residual_px) / points[i].sigma_px;
  }
  if (near < 5) return std::nullopt;
  std::nth_element(sizes.begin(), sizes.begin() + near / 2, sizes.begin() + near);
  return sizes[near / 2] / 0.6745;
}

/// Sums of one step of iteratively reweighted least squares.
struct WeightedSums {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero(), G = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double psi2 = 0, slope_of_psi = 0;  // of Tukey's biweight
  double points = 0;                  // sum of the weights
};

/// Weights the points by their residuals with Tukey's biweight, zero beyond `reach` sigmas, and sums them up.
WeightedSums weigh(std::span<ContourPoint> points, const Directions& directions, const Slopes& slopes, double reach,
                   double largest_px) {
  WeightedSums sums;
  for (int i = 0; i < directions.count; ++i) {
    ContourPoint& point = points[i];
    const double z = point.residual_px / point.sigma_px, t = z / reach;
    point.weight = std::abs(t) < 1 && std::abs(point.residual_px) < largest_px ? (1 - t * t) * (1 - t * t) : 0;
    point.pull.setZero();
    if (point.weight == 0) continue;
    const Eigen::Vector3d& e = directions.of[i].e;
    const double slope = slopes[i];
    const double w = point.weight / (slope * slope * point.sigma_px * point.sigma_px);
    point.pull = -w * slope * e;
    const Eigen::Matrix3d square = e * e.transpose();
    sums.A += w * square;
    sums.G += point.weight / (slope * slope) * square;
    sums.b += w * e;
    sums.psi2 += point.weight * point.weight * z * z;
    sums.slope_of_psi += (1 - t * t) * (1 - 5 * t * t);
    sums.points += point.weight;
  }
  return sums;
}

}  // namespace

std::optional<ConeFit> fit_cone(std::span<ContourPoint> points, const Eigen::Matrix2d& d_ray_d_pixel,
                                const RobustFit& options, const ContourCone* start) {
  Directions directions;
  directions.count = static_cast<int>(std::min<size_t>(points.size(), kMaxContourPoints));
  if (directions.count < 5) return std::nullopt;
  for (int i = 0; i < directions.count; ++i) directions.of[i] = Direction(points[i], d_ray_d_pixel);
  std::optional<Eigen::Vector3d> found;
  if (options.trials > 0) {
    found = best_of_trials(directions, options);
  } else if (start) {
    found = start->n;
  }
  if (!found) return std::nullopt;

  Eigen::Vector3d n = *found;
  ConeFit fit;
  Slopes slopes;
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    const auto scale = robust_scale(points, directions, n, options.largest_px, slopes);
    if (!scale) return std::nullopt;
    fit.scale = *scale;
    const WeightedSums sums =
        weigh(points, directions, slopes, options.tuning * std::max(1.0, fit.scale), options.largest_px);
    fit.points = sums.points;
    const Eigen::LDLT<Eigen::Matrix3d> ldlt(sums.A);
    if (ldlt.info() != Eigen::Success || fit.points < 5) return std::nullopt;
    const Eigen::Vector3d before = n;
    n = ldlt.solve(sums.b);
    if (!is_cone(n)) return std::nullopt;
    // A slope converts the step to pixels; the slopes of one contour are nearly equal, so the first one serves.
    if (round < kRounds - 1 && (n - before).norm() > kConverged * std::abs(slopes[0])) continue;
    fit.covariance = sums.A.inverse();
    fit.geometry = (sums.G / fit.points).inverse();
    // The asymptotic variance of an M-estimator (Huber, Robust Statistics, Sect. 7.6), relative to the sum of
    // the weights.
    fit.spread = sums.psi2 * fit.points / std::max(1.0, sums.slope_of_psi * sums.slope_of_psi);
    break;
  }
  fit.cone.n = n;
  return fit;
}

}  // namespace multireach::vision
