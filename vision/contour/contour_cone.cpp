#include "vision/contour/contour_cone.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "numeric/median.hpp"
#include "numeric/random.hpp"
#include "vision/contour/contour_directions.hpp"

namespace multireach::vision {
namespace {

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

/// RANSAC: the cone through three points that most of the others support, if enough do.
std::optional<Eigen::Vector3d> best_of_trials(const ContourDirections& directions, const ContourDirections& voters,
                                              const RobustFit& options) {
  std::optional<Eigen::Vector3d> n;
  double best = voters.count() * (1 - options.smallest_share);
  // Probability that no trial so far had three inliers, given the inlier share of the best cone.
  double missed = 1;
  const CounterRandom random(20081);
  for (int trial = 0; trial < options.trials && missed > kMissed; ++trial) {
    const double good = n ? 1 - best / voters.count() : 0;
    missed *= 1 - good * good * good;
    Eigen::Matrix3d E;
    const auto modulus = static_cast<uint64_t>(directions.count());
    for (int k = 0; k < 3; ++k) {
      const uint64_t drawn = random.bits(static_cast<uint64_t>(3 * trial + k)) % modulus;
      E.row(k) = directions.direction(static_cast<int>(drawn)).transpose();
    }
    const double det = E.determinant();
    if (!(std::abs(det) > 1e-12)) continue;
    const Eigen::Vector3d tried = E.inverse() * Eigen::Vector3d::Ones();
    if (!is_cone(tried)) continue;
    const double cost = voters.cost(tried, options.gate_px, best);
    if (cost >= best) continue;
    best = cost;
    n = tried;
  }
  return n;
}

/// Robust standard deviation of residual / sigma of the points near a cone (the others are outliers); nothing when
/// there are too few.
std::optional<double> robust_scale(int count, const PointNumbers& residuals_px, const PointNumbers& sigmas_px,
                                   double largest_px) {
  std::array<double, kMaxContourPoints> sizes;
  int near = 0;
  for (int i = 0; i < count; ++i) {
    const double size = std::abs(residuals_px[i]);
    if (size < largest_px) sizes[near++] = size / sigmas_px[i];
  }
  if (near < 5) return std::nullopt;
  return median_of(std::span(sizes).first(static_cast<size_t>(near))) / 0.6745;
}

/// A symmetric matrix: xx, xy, xz, yy, yz, zz.
struct Symmetric {
  std::array<double, 6> of{};
  void add(double weight, const Symmetric& other) {
    for (size_t k = 0; k < of.size(); ++k) of[k] += weight * other.of[k];
  }
  Eigen::Matrix3d matrix() const {
    Eigen::Matrix3d m;
    m << of[0], of[1], of[2], of[1], of[3], of[4], of[2], of[4], of[5];
    return m;
  }
};

/// Sums of one step of iteratively reweighted least squares.
struct WeightedSums {
  Symmetric A, G;
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double psi2 = 0, slope_of_psi = 0;  // of Tukey's biweight
  double points = 0;                  // sum of the weights
};

WeightedSums sum_up(const ContourDirections& directions, const PointWeights& weights) {
  WeightedSums sums;
  Symmetric A, G;  // in registers
  double x = 0, y = 0, z = 0;
  for (int i = 0; i < directions.count(); ++i) {
    if (weights.weight[i] == 0) continue;
    const Eigen::Vector3d e = directions.direction(i);
    const double w = weights.by_sigma[i];
    const Symmetric square{{e.x() * e.x(), e.x() * e.y(), e.x() * e.z(), e.y() * e.y(), e.y() * e.z(), e.z() * e.z()}};
    A.add(w, square);
    G.add(weights.by_slope[i], square);
    x += w * e.x();
    y += w * e.y();
    z += w * e.z();
    sums.psi2 += weights.psi2[i];
    sums.slope_of_psi += weights.psi_derivative[i];
    sums.points += weights.weight[i];
  }
  sums.A = A;
  sums.G = G;
  sums.b = {x, y, z};
  return sums;
}

/// Sets the weights, residuals and pulls of the points.
void store_results(const ContourDirections& directions, const PointWeights& weights, const PointNumbers& residuals_px,
                   const PointNumbers& slopes, std::span<ContourPoint> points) {
  for (int i = 0; i < directions.count(); ++i) {
    ContourPoint& point = points[static_cast<size_t>(i)];
    point.weight = weights.weight[i];
    point.residual_px = residuals_px[i];
    point.pull.setZero();
    if (point.weight != 0) point.pull = -weights.by_sigma[i] * slopes[i] * directions.direction(i);
  }
}

}  // namespace

std::optional<ConeFit> fit_cone(std::span<ContourPoint> points, const Eigen::Matrix2d& d_ray_d_pixel,
                                const RobustFit& options, const ContourCone* start) {
  if (points.size() < 5) return std::nullopt;
  points = points.first(std::min<size_t>(points.size(), kMaxContourPoints));
  ContourDirections directions;
  directions.set(points, d_ray_d_pixel);
  const int count = directions.count();
  std::optional<Eigen::Vector3d> found;
  if (options.trials > 0) {
    // A subset of the points scores each candidate cone, to save time.
    constexpr int kVoters = 64;
    ContourDirections some;
    if (count > kVoters) some.set(points, d_ray_d_pixel, 1 + (count - 1) / kVoters);
    found = best_of_trials(directions, count > kVoters ? some : directions, options);
  } else if (start) {
    found = start->n;
  }
  if (!found) return std::nullopt;

  Eigen::Vector3d n = *found;
  ConeFit fit;
  PointNumbers sigmas_px, residuals_px, slopes;
  PointWeights weights;
  for (int i = 0; i < count; ++i) sigmas_px[i] = points[static_cast<size_t>(i)].sigma_px;
  for (int i = count; i % kRowLanes != 0; ++i) sigmas_px[i] = 1;
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    directions.compare(n, slopes, residuals_px);
    const auto scale = robust_scale(count, residuals_px, sigmas_px, options.largest_px);
    if (!scale) return std::nullopt;
    fit.scale = *scale;
    weights.set(count, residuals_px, sigmas_px, slopes, options.tuning * std::max(1.0, fit.scale), options.largest_px);
    const WeightedSums sums = sum_up(directions, weights);
    fit.points = sums.points;
    const Eigen::Matrix3d A = sums.A.matrix();
    const Eigen::LDLT<Eigen::Matrix3d> ldlt(A);
    if (ldlt.info() != Eigen::Success || fit.points < 5) return std::nullopt;
    const Eigen::Vector3d before = n;
    n = ldlt.solve(sums.b);
    if (!is_cone(n)) return std::nullopt;
    // A slope converts the step to pixels; the slopes of one contour are nearly equal, so the first one serves.
    if (round < kRounds - 1 && (n - before).norm() > kConverged * std::abs(slopes[0])) continue;
    store_results(directions, weights, residuals_px, slopes, points);
    fit.covariance = A.inverse();
    fit.geometry = (sums.G.matrix() / fit.points).inverse();
    // The asymptotic variance of an M-estimator (Huber, Robust Statistics, Sect. 7.6), relative to the sum of
    // the weights.
    fit.spread = sums.psi2 * fit.points / std::max(1.0, sums.slope_of_psi * sums.slope_of_psi);
    break;
  }
  fit.cone.n = n;
  return fit;
}

}  // namespace multireach::vision
