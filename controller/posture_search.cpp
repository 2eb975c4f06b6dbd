#include "controller/posture_search.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kinematics/random.hpp"

namespace multireach::controller {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// The damped Newton step for `error` (m), with the joints whose limit stands in the way left out.
JointVector damped_step(const Chain& chain, const JointVector& posture, PositionJacobian jacobian,
                        const Eigen::Vector3d& error, double damping) {
  JointVector step = JointVector::Zero(chain.size());
  for (int round = 0; round < chain.size(); ++round) {
    const Eigen::Matrix3d A = jacobian * jacobian.transpose() + damping * Eigen::Matrix3d::Identity();
    step = jacobian.transpose() * A.llt().solve(error);
    bool blocked = false;
    for (int i = 0; i < chain.size(); ++i) {
      const bool out =
          (posture[i] <= chain.lower()[i] && step[i] < 0) || (posture[i] >= chain.upper()[i] && step[i] > 0);
      if (!out) continue;
      jacobian.col(i).setZero();
      blocked = true;
    }
    if (!blocked) break;
  }
  return step;
}

}  // namespace

PostureSearch::PostureSearch(const Chain& chain, const PostureSearchOptions& options)
    : chain_(chain), options_(options), shoulder_elbow_(ShoulderElbow::from(chain)) {}

std::optional<JointVector> PostureSearch::nearest(const Eigen::Vector3d& x_T, const JointVector& theta) const {
  if (!x_T.allFinite() || !theta.allFinite()) return std::nullopt;
  if (shoulder_elbow_) {
    if (auto posture = shoulder_elbow_->nearest(chain_, x_T, theta, options_.samples)) return posture;
    // The postures inside the limits may all lie between two samples.
  }
  return multi_start(x_T, theta);
}

bool PostureSearch::solve(const Eigen::Vector3d& x_T, JointVector& posture) const {
  constexpr int kMaxSteps = 60;
  constexpr double kLargestStep = 0.5;  // rad (or m) of any joint, so that the linearisation keeps its sense
  Eigen::Vector3d x;
  PositionJacobian jacobian;
  double damping = 1e-4;  // m^2, against singular values of some 0.1 m; adapted as Levenberg and Marquardt do
  chain_.position_and_jacobian(posture, x, jacobian);
  double error = (x_T - x).norm();
  for (int k = 0; k < kMaxSteps && error > options_.tolerance_m; ++k) {
    JointVector step = damped_step(chain_, posture, jacobian, x_T - x, damping);
    const double largest = step.cwiseAbs().maxCoeff();
    if (largest > kLargestStep) step *= kLargestStep / largest;
    const JointVector candidate = chain_.clamped(posture + step);
    Eigen::Vector3d candidate_x;
    PositionJacobian candidate_jacobian;
    chain_.position_and_jacobian(candidate, candidate_x, candidate_jacobian);
    const double candidate_error = (x_T - candidate_x).norm();
    if (candidate_error < error) {
      posture = candidate;
      x = candidate_x;
      jacobian = candidate_jacobian;
      error = candidate_error;
      damping = std::max(damping * 0.2, 1e-15);
    } else {
      damping *= 8;
      if (damping > 1e4) break;
    }
  }
  return error <= options_.tolerance_m;
}

void PostureSearch::approach(const Eigen::Vector3d& x_T, const JointVector& theta, JointVector& posture) const {
  constexpr int kMaxSteps = 40;
  double stride = 1;
  double distance = (posture - theta).squaredNorm();
  for (int k = 0; k < kMaxSteps && stride > 1e-3; ++k) {
    Eigen::Vector3d x;
    PositionJacobian jacobian;
    chain_.position_and_jacobian(posture, x, jacobian);
    const JointVector wanted = stride * (theta - posture);
    // What of it does not move the hand; the damping keeps this finite where the arm is singular.
    const JointVector self_motion = wanted - damped_step(chain_, posture, jacobian, jacobian * wanted, 1e-9);
    JointVector candidate = chain_.clamped(posture + self_motion);
    const bool reaches = solve(x_T, candidate);
    const double candidate_distance = (candidate - theta).squaredNorm();
    if (reaches && candidate_distance < distance) {
      const bool settled = distance - candidate_distance < 1e-12;
      posture = candidate;
      distance = candidate_distance;
      stride = std::min(1.0, stride * 2);
      if (settled) break;
    } else {
      stride *= 0.5;
    }
  }
}

std::optional<JointVector> PostureSearch::multi_start(const Eigen::Vector3d& x_T, const JointVector& theta) const {
  const CounterRandom random(options_.seed);
  std::optional<JointVector> best;
  double best_distance = std::numeric_limits<double>::infinity();
  uint64_t counter = 0;
  for (int start = 0; start <= options_.starts; ++start) {
    JointVector posture = chain_.clamped(theta);
    if (start > 0) {
      for (int i = 0; i < chain_.size(); ++i) {
        posture[i] = random.uniform(counter++, chain_.sample_lower(i), chain_.sample_upper(i));
      }
    }
    if (!solve(x_T, posture)) continue;
    for (int i = 0; i < chain_.size(); ++i) {
      if (!chain_.joint(i).limited()) posture[i] -= kTurn * std::round((posture[i] - theta[i]) / kTurn);
    }
    approach(x_T, theta, posture);
    const double distance = (posture - theta).squaredNorm();
    if (distance < best_distance) {
      best_distance = distance;
      best = posture;
    }
  }
  return best;
}

}  // namespace multireach::controller
