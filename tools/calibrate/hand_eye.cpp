#include "tools/calibrate/hand_eye.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "numeric/random.hpp"
#include "numeric/trigonometry.hpp"
#include "tools/calibrate/rigid_fit.hpp"

namespace multireach {
namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Matrix39 = Eigen::Matrix<double, 3, 9>;

constexpr double kMedianChi2 = 2.366;  // three degrees of freedom
constexpr double kMaxChi2 = 21.108;    // three degrees of freedom; exceeded once in 10^4

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

class Solver {
 public:
  Solver(const std::vector<HandEyeSample>& samples, const HandEyeOptions& options)
      : samples_(samples), options_(options), weights_(samples.size(), 1.0) {
    result_.p_HT = options.p_HT;
  }

  HandEye solve() {
    check_samples();
    start();
    constexpr int kRobustSteps = 50, kRounds = 20, kSteps = 20;
    for (int k = 0; k < kRobustSteps; ++k) {
      update_huber_weights();
      step();
    }
    for (int round = 0; round < kRounds; ++round) {
      const bool changed = reject_outliers();
      for (int k = 0; k < kSteps; ++k) step();
      if (!changed) break;
    }
    compute_statistics();
    return std::move(result_);
  }

 private:
  int unknowns() const { return options_.estimate_offset ? 9 : 6; }
  Eigen::Vector3d reported_position(const HandEyeSample& sample) const { return sample.X_WH * result_.p_HT; }
  Eigen::Vector3d residual(const HandEyeSample& sample) const {
    return reported_position(sample) - result_.X_WL * sample.p_LT;
  }

  Eigen::Matrix3d information(const HandEyeSample& sample) const {
    const Eigen::Matrix3d R = result_.X_WL.linear();
    const Eigen::Matrix3d covariance = R * sample.covariance * R.transpose() +
                                       options_.hand_sigma_m * options_.hand_sigma_m * Eigen::Matrix3d::Identity();
    return covariance.inverse();
  }
  double chi2(const HandEyeSample& sample) const {
    const Eigen::Vector3d r = residual(sample);
    return r.dot(information(sample) * r);
  }
  std::vector<double> all_chi2() const {
    std::vector<double> values;
    for (const HandEyeSample& sample : samples_) values.push_back(chi2(sample));
    return values;
  }

  void check_samples() const {
    const size_t least = options_.estimate_offset ? 5 : 4;
    if (samples_.size() < least) {
      throw std::runtime_error(fmt::format("the target is seen at {} hand positions; {} are needed, better 10 or more",
                                           samples_.size(), least));
    }
    Eigen::Matrix3Xd hands(3, static_cast<Eigen::Index>(samples_.size()));
    for (Eigen::Index k = 0; k < hands.cols(); ++k) hands.col(k) = reported_position(samples_[static_cast<size_t>(k)]);
    hands.colwise() -= hands.rowwise().mean().eval();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(hands * hands.transpose() /
                                                              static_cast<double>(hands.cols()));
    const double spread_beside = std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
    constexpr double kLeast = 0.01;
    if (spread_beside < kLeast) {
      throw std::runtime_error(fmt::format(
          "the hand positions lie on a line, or nearly so ({:.1f} mm off); move the hand in at least two directions, "
          "by some centimetres",
          1e3 * spread_beside));
    }
  }

  /// Least median of squares over rigid fits to three positions each: tolerates up to half of them being wrong.
  void start() {
    const CounterRandom random(1);
    constexpr uint64_t kTrials = 500;
    double best = std::numeric_limits<double>::infinity();
    for (uint64_t trial = 0; trial < kTrials; ++trial) {
      Eigen::Matrix3d seen, hands;
      for (int k = 0; k < 3; ++k) {
        const HandEyeSample& sample = samples_[random.bits(3 * trial + static_cast<uint64_t>(k)) % samples_.size()];
        seen.col(k) = sample.p_LT;
        hands.col(k) = reported_position(sample);
      }
      const Eigen::Vector3d a = hands.col(1) - hands.col(0), b = hands.col(2) - hands.col(0);
      constexpr double kMinSine = 0.1;
      if (!(a.cross(b).norm() > kMinSine * a.norm() * b.norm())) continue;
      const Eigen::Isometry3d X = rigid_fit(seen, hands);
      std::vector<double> squares;
      for (const HandEyeSample& sample : samples_)
        squares.push_back((reported_position(sample) - X * sample.p_LT).squaredNorm());
      const double middle = median(std::move(squares));
      if (!(middle < best)) continue;
      best = middle;
      result_.X_WL = X;
    }
    if (!std::isfinite(best)) {
      throw std::runtime_error("no three hand positions form a triangle; move the hand in at least two directions");
    }
  }

  /// Huber weights, scaled by the median.
  void update_huber_weights() {
    const std::vector<double> values = all_chi2();
    const double limit = 2.5 * std::sqrt(std::max(1.0, median(values) / kMedianChi2));
    for (size_t k = 0; k < samples_.size(); ++k)
      weights_[k] = std::min(1.0, limit / std::sqrt(std::max(values[k], 1e-300)));
  }

  /// Rejects outliers; returns whether the set of used positions has changed.
  bool reject_outliers() {
    const std::vector<double> values = all_chi2();
    const double limit = kMaxChi2 * std::max(1.0, median(values) / kMedianChi2);
    bool changed = false;
    for (size_t k = 0; k < samples_.size(); ++k) {
      const double weight = values[k] > limit ? 0 : 1;
      changed = changed || weight != weights_[k];
      weights_[k] = weight;
    }
    return changed;
  }

  Eigen::MatrixXd normal_matrix(Vector9& gradient) const {
    Matrix9 JtJ = Matrix9::Zero();
    gradient.setZero();
    for (size_t k = 0; k < samples_.size(); ++k) {
      const HandEyeSample& sample = samples_[k];
      Matrix39 J;
      J << cross(result_.X_WL.linear() * sample.p_LT), -Eigen::Matrix3d::Identity(), sample.X_WH.linear();
      const Eigen::Matrix3d information_k = weights_[k] * information(sample);
      JtJ += J.transpose() * information_k * J;
      gradient += J.transpose() * information_k * residual(sample);
    }
    return JtJ.topLeftCorner(unknowns(), unknowns());
  }

  void step() {
    Vector9 gradient;
    const Eigen::MatrixXd JtJ = normal_matrix(gradient);
    Vector9 change = Vector9::Zero();
    // Undetermined directions get no change (minimum-norm solution); the end of the solver checks whether there are
    // any.
    change.head(unknowns()) = -JtJ.completeOrthogonalDecomposition().solve(gradient.head(unknowns()));
    const double angle = change.head<3>().norm();
    if (angle > 0) result_.X_WL.linear() = rotation_about(change.head<3>() / angle, angle) * result_.X_WL.linear();
    result_.X_WL.translation() += change.segment<3>(3);
    result_.p_HT += change.tail<3>();
  }

  void compute_statistics() {
    double chi2_sum = 0, square_sum = 0;
    size_t used = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (size_t k = 0; k < samples_.size(); ++k) {
      result_.distances_m.push_back(residual(samples_[k]).norm());
      result_.outlier.push_back(weights_[k] == 0);
      if (weights_[k] == 0) continue;
      ++used;
      chi2_sum += chi2(samples_[k]);
      square_sum += result_.distances_m[k] * result_.distances_m[k];
      sum += reported_position(samples_[k]);
    }
    if (2 * used < samples_.size() || 3 * used <= static_cast<size_t>(unknowns())) {
      throw std::runtime_error(
          fmt::format("only {} of {} positions agree with each other; do the cameras see the target in the hand?", used,
                      samples_.size()));
    }
    const auto count = static_cast<double>(used);
    result_.rms_m = std::sqrt(square_sum / count);
    result_.chi2_per_dof = chi2_sum / (3 * count - unknowns());
    double spread = 0;
    for (size_t k = 0; k < samples_.size(); ++k) {
      if (weights_[k] > 0) spread += (reported_position(samples_[k]) - sum / count).squaredNorm() / count;
    }
    if (result_.rms_m > 0.25 * std::sqrt(spread)) {
      throw std::runtime_error(
          fmt::format("the seen target does not move with the hand ({:.1f} mm rms, hand positions spread over {:.1f} "
                      "mm): another target, another unit, or a target that the hand does not hold",
                      1e3 * result_.rms_m, 1e3 * std::sqrt(spread)));
    }
    check_uncertainty();
  }

  void check_uncertainty() {
    Vector9 gradient;
    const Eigen::MatrixXd JtJ = normal_matrix(gradient);
    const Eigen::FullPivLU<Eigen::MatrixXd> inverse(JtJ);
    constexpr double kMaxAngleSigma = 0.1, kMaxOffsetSigma = 0.02;  // rad, m; largest acceptable standard deviations
    const Eigen::MatrixXd covariance = std::max(1.0, result_.chi2_per_dof) * JtJ.inverse();
    const auto sigma = [&covariance](int from) { return std::sqrt(covariance.diagonal().segment<3>(from).maxCoeff()); };
    if (options_.estimate_offset && !(inverse.isInvertible() && sigma(6) < kMaxOffsetSigma)) {
      throw std::runtime_error(
          "the hand's orientation varies too little to estimate the offset; turn the hand more, or measure the offset "
          "and give it");
    }
    if (!(inverse.isInvertible() && sigma(0) < kMaxAngleSigma)) {
      throw std::runtime_error(
          "the positions do not determine the camera's orientation to 6 degrees; move the hand further, and in all "
          "directions");
    }
    result_.covariance = covariance.topLeftCorner<6, 6>();
    if (options_.estimate_offset) result_.offset_covariance = covariance.bottomRightCorner<3, 3>();
  }

  const std::vector<HandEyeSample>& samples_;
  const HandEyeOptions& options_;
  std::vector<double> weights_;
  HandEye result_;
};

}  // namespace

HandEye solve_hand_eye(const std::vector<HandEyeSample>& samples, const HandEyeOptions& options) {
  return Solver(samples, options).solve();
}

}  // namespace multireach
