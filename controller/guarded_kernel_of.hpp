#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "controller/box_program.hpp"
#include "controller/guarded_kernel.hpp"
#include "controller/guarded_settings.hpp"
#include "controller/hand_error.hpp"
#include "controller/pair_program.hpp"
#include "kinematics/fast_chain.hpp"

namespace multireach::controller {

/// The guarded law for N joints (0: any number). The arm at theta and the arm at theta_T are computed side by side, in
/// the two lanes of a Pair: their kinematics, their M x M systems, and what these give for the joints.
template <int N>
class GuardedKernelOf final : public GuardedKernel {
 public:
  GuardedKernelOf(const Chain& chain, const Eigen::Matrix3d& tool, const GuardedSettings& settings)
      : chain_(chain, tool), tool_(tool), settings_(settings) {}

  std::unique_ptr<GuardedKernel> clone() const override { return std::make_unique<GuardedKernelOf>(*this); }

  void refresh(GuardedState& state) override { update_hand<true>(state); }

  void forget_progress(GuardedState& state) const override {
    state.best_distance = state.stalled_distance = std::numeric_limits<double>::infinity();
    state.idle_steps = state.waited_steps = 0;
    state.ceiling = settings_.gamma;
  }

  int step(const HandTarget& target, std::span<const NearPair> pairs, GuardedState& state) override {
    switch (target.aim) {
      case Aim::kPosition:
        return step_of<3>(target, pairs, state);
      case Aim::kPointing:
        return step_of<5>(target, pairs, state);
      case Aim::kPose:
        return step_of<6>(target, pairs, state);
    }
    return 0;
  }

 private:
  using Tuning = GuardedTuning;
  using Arm = FastChain<N, Pair>;
  static constexpr int kCapacity = Arm::kCapacity;
  using Joints = std::array<double, kCapacity>;
  using PairJoints = std::array<Pair, kCapacity>;
  template <int M>
  using Rows = std::array<PairJoints, M>;

  int size() const { return chain_.size(); }

  template <bool kRotation>
  void update_hand(GuardedState& state) {
    PairJoints both;
    for (int i = 0; i < size(); ++i) both[i] = Pair{state.theta[i], state.theta_target[i]};
    chain_.template hand<kRotation>(both, hand_);
    for (int k = 0; k < 3; ++k) {
      state.x[k] = hand_.position[k][0];
      state.x_target[k] = hand_.position[k][1];
    }
    has_rotation_ = kRotation;
  }

  std::array<std::array<double, 3>, 3> rotation(int lane) const {
    std::array<std::array<double, 3>, 3> columns;
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 3; ++k) columns[c][k] = hand_.rotation[c][k][lane];
    }
    return columns;
  }

  /// The rows of the task's Jacobian, and the errors theta -> theta_T and theta_T -> target in the same rows. Rows of
  /// rotation are in metres.
  template <int M>
  void task(const HandTarget& target, Rows<M>& J, std::array<double, M>& error, std::array<double, M>& residual) const {
    for (int k = 0; k < 3; ++k) {
      J[k] = hand_.jacobian[k];
      error[k] = hand_.position[k][1] - hand_.position[k][0];
      residual[k] = target.position[k] - hand_.position[k][1];
    }
    if constexpr (M > 3) {
      const double length = settings_.orientation_length;
      const auto R = rotation(0), R_T = rotation(1);
      if constexpr (M == 6) {
        const auto goal = columns_of(target.orientation * tool_);
        const auto w = rotation_vector(R, R_T), w_T = rotation_vector(R_T, goal);
        for (int k = 0; k < 3; ++k) {
          for (int i = 0; i < size(); ++i) J[3 + k][i] = hand_.jacobian[3 + k][i] * length;
          error[3 + k] = length * w[k];
          residual[3 + k] = length * w_T[k];
        }
      } else {
        const auto w = pointing_vector(R[2], R_T[2], R[0]);
        const std::array<double, 3> wanted{target.direction[0], target.direction[1], target.direction[2]};
        const auto w_T = pointing_vector(R_T[2], wanted, R_T[0]);
        for (int r = 0; r < 2; ++r) {
          const auto& across = hand_.rotation[r];
          for (int i = 0; i < size(); ++i) {
            J[3 + r][i] = (across[0] * hand_.jacobian[3][i] + across[1] * hand_.jacobian[4][i] +
                           across[2] * hand_.jacobian[5][i]) *
                          length;
          }
          error[3 + r] = length * (across[0][0] * w[0] + across[1][0] * w[1] + across[2][0] * w[2]);
          residual[3 + r] = length * (across[0][1] * w_T[0] + across[1][1] * w_T[1] + across[2][1] * w_T[2]);
        }
      }
    }
  }

  template <int M>
  int step_of(const HandTarget& target, std::span<const NearPair> pairs, GuardedState& state) {
    const int n = size();
    const auto [alpha, beta] = settings_.gains;
    if (M > 3 && !has_rotation_) update_hand<true>(state);
    Rows<M> J;
    std::array<double, M> error, residual;
    task<M>(target, J, error, residual);
    double residual2 = 0;
    for (const double element : residual) residual2 += element * element;

    // What both systems have on their right: lane 0 the hand's attractor less what the joints' already gives, lane 1
    // what theta_T lacks less what its self-motion would add.
    const double damping = posture_damping(target, residual2, state), self_motion = self_motion_of(state);
    Joints wanted;
    PairJoints base;
    double apart2 = 0;
    std::array<Pair, M> b;
    const Joints drift = feed_forward<M>(target, J);
    for (int i = 0; i < n; ++i) {
      const double apart = state.theta_target[i] - state.theta[i];
      apart2 += apart * apart;
      wanted[i] = state.velocity[i] + alpha * (drift[i] - state.velocity[i] + beta * apart + state.push[i]);
      base[i] = Pair{wanted[i], -self_motion * apart};
    }
    std::array<double, M> hand;
    for (int m = 0; m < M; ++m) {
      double ahead = 0;
      if (moving_) {
        for (int i = 0; i < n; ++i) ahead += J[m][i][0] * drift[i];
      }
      hand[m] = state.hand_velocity[m] + alpha * (ahead - state.hand_velocity[m] + beta * error[m]);
      Pair covered{};
      for (int i = 0; i < n; ++i) covered += J[m][i] * base[i];
      b[m] = Pair{hand[m], residual[m]} - covered;
    }
    const double gamma = state.gamma;
    const Pair scale{gamma, 1}, diagonal{1, damping};
    typename SmallSolve<M, Pair>::Matrix A;
    for (int r = 0; r < M; ++r) {
      for (int c = 0; c <= r; ++c) {
        Pair sum{};
        for (int i = 0; i < n; ++i) sum += J[r][i] * J[c][i];
        A[r][c] = r == c ? scale * sum + diagonal : scale * sum;
      }
    }
    const std::array<Pair, M> y = SmallSolve<M, Pair>(A).solve(b);

    // The joints' velocity inside its bounds, and the step of theta_T inside its own.
    std::array<VelocityRange, kCapacity> range;
    Joints velocity, posture_step;
    bool bounded = false, blocked = false;
    double largest = 0, pull2 = 0, speed2 = 0, error2 = 0;
    for (const double element : error) error2 += element * element;
    for (int i = 0; i < n; ++i) {
      Pair sum{};
      for (int m = 0; m < M; ++m) sum += J[m][i] * y[m];
      const Pair result = base[i] + scale * sum;
      velocity[i] = result[0];
      posture_step[i] = result[1];
      range[i] = velocity_range(state.theta[i], state.velocity[i], settings_.lower[i], settings_.upper[i],
                                settings_.speed[i], settings_.acceleration[i], settings_.barrier_rate);
      bounded = bounded || !(velocity[i] >= range[i].lower && velocity[i] <= range[i].upper);
      const double next = state.theta_target[i] + posture_step[i];
      blocked = blocked || next < settings_.lower[i] || next > settings_.upper[i];
      largest = std::max(largest, std::abs(posture_step[i]));
      const double pull = std::clamp(beta * (state.theta_target[i] - state.theta[i]), range[i].lower, range[i].upper);
      pull2 += pull * pull;
    }
    int iterations = 0;
    state.obstructed = obstructs(pairs, velocity);
    if (state.obstructed) {
      PairProgram<M, kCapacity> program{.n = n,
                                        .gamma = gamma,
                                        .jacobian = {},
                                        .wanted = wanted,
                                        .hand = hand,
                                        .range = range,
                                        .pairs = pairs,
                                        .rate = settings_.barrier_rate.slope};
      for (int m = 0; m < M; ++m) {
        for (int i = 0; i < n; ++i) program.jacobian[m][i] = J[m][i][0];
      }
      iterations = program.solve(velocity);
    } else if (bounded) {
      BoxProgram<M, kCapacity> program{
          .n = n, .gamma = gamma, .jacobian = {}, .wanted = wanted, .hand = hand, .range = range};
      std::array<double, M> multiplier;
      for (int m = 0; m < M; ++m) {
        multiplier[m] = y[m][0];
        for (int i = 0; i < n; ++i) program.jacobian[m][i] = J[m][i][0];
      }
      velocity = program.solve(multiplier, iterations);
    }
    if (state.posture_fixed) {
      posture_step.fill(0);
    } else if (blocked) {
      largest = unblocked_posture_step<M>(J, residual, damping, state, posture_step);
    }
    const double shrink = largest > Tuning::kLargestPostureStep ? Tuning::kLargestPostureStep / largest : 1;

    for (int m = 0; m < M; ++m) {
      double sum = 0;
      for (int i = 0; i < n; ++i) sum += J[m][i][0] * velocity[i];
      state.hand_velocity[m] = sum;
    }
    for (int i = 0; i < n; ++i) {
      speed2 += velocity[i] * velocity[i];
      state.velocity[i] = velocity[i];
      const double next = state.theta[i] + velocity[i];
      // Only rounding can be beyond the limit here, unless the arm was there already.
      const bool inside = state.theta[i] >= settings_.lower[i] && state.theta[i] <= settings_.upper[i];
      state.theta[i] = inside ? std::clamp(next, settings_.lower[i], settings_.upper[i]) : next;
      state.theta_target[i] =
          std::clamp(state.theta_target[i] + shrink * posture_step[i], settings_.lower[i], settings_.upper[i]);
    }
    state.slow = speed2 < Tuning::kStalledBelow * Tuning::kStalledBelow * pull2;
    schedule_gamma(state.slow, std::sqrt(apart2), std::sqrt(error2), state);
    watch_posture(std::sqrt(residual2), state);
    update_hand<(M > 3)>(state);
    return iterations;
  }

  /// Whether a distance would shrink faster than it may.
  bool obstructs(std::span<const NearPair> pairs, const Joints& velocity) const {
    for (const NearPair& pair : pairs) {
      double sum = settings_.barrier_rate.slope * pair.clearance;
      for (int i = 0; i < size(); ++i) sum += pair.gradient[i] * velocity[i];
      if (sum < 0) return true;
    }
    return false;
  }

  /// The part of theta - theta_T that theta_T makes up in a step, where that does not move its hand. None while
  /// something is in the arm's way: the two would drive each other along it.
  static double self_motion_of(const GuardedState& state) {
    return state.obstructed ? 0 : Tuning::kSelfMotion / state.caution;
  }

  /// Damping of theta_T's step, m^2: large against small singular values while the target is far, and vanishing with
  /// the square of the error, so that stretched postures are reached exactly. It grows while the error does not fall,
  /// as Levenberg and Marquardt's does, so that theta_T comes to rest before a target out of reach.
  double posture_damping(const HandTarget& target, double residual2, GuardedState& state) const {
    const double reach2 = settings_.reach * settings_.reach;
    bool rests = true;
    for (int k = 0; k < 3; ++k) {
      rests = rests && target.position[k] == state.last_target[k];
      state.last_target[k] = target.position[k];
    }
    const bool worse =
        rests && residual2 > state.residual * state.residual && residual2 > Tuning::kReached * Tuning::kReached;
    state.caution = worse ? std::min(state.caution * Tuning::kCautionRise, Tuning::kMostCaution)
                          : std::max(1.0, state.caution * Tuning::kCautionFall);
    return state.caution *
           (Tuning::kFarDamping * std::min(reach2, Tuning::kNearDamping * residual2) + Tuning::kLeastDamping * reach2);
  }

  /// The joint velocity that carries theta_T along with a moving target, damped where the arm is singular.
  template <int M>
  Joints feed_forward(const HandTarget& target, const Rows<M>& J) {
    Joints drift{};
    moving_ = !target.velocity.isZero(0);
    if (!moving_) return drift;
    const int n = size();
    typename SmallSolve<M, double>::Matrix A;
    std::array<double, M> b{};
    for (int k = 0; k < 3; ++k) b[k] = target.velocity[k];
    for (int r = 0; r < M; ++r) {
      for (int c = 0; c <= r; ++c) {
        A[r][c] = r == c ? Tuning::kFarDamping * settings_.reach * settings_.reach : 0;
        for (int i = 0; i < n; ++i) A[r][c] += J[r][i][1] * J[c][i][1];
      }
    }
    const auto y = SmallSolve<M, double>(A).solve(b);
    double largest = 0;
    for (int i = 0; i < n; ++i) {
      for (int m = 0; m < M; ++m) drift[i] += J[m][i][1] * y[m];
      largest = std::max(largest, std::abs(drift[i]));
    }
    if (largest > Tuning::kLargestPostureStep) {
      for (double& element : drift) element *= Tuning::kLargestPostureStep / largest;
    }
    return drift;
  }

  /// The step of theta_T with the joints left out that would leave their limits. Returns its largest element.
  template <int M>
  double unblocked_posture_step(const Rows<M>& J, const std::array<double, M>& residual, double damping,
                                const GuardedState& state, Joints& step) const {
    const int n = size();
    const double self_motion = self_motion_of(state);
    std::array<bool, kCapacity> frozen{};
    double largest = 0;
    for (int round = 0; round < n; ++round) {
      bool changed = false;
      for (int i = 0; i < n; ++i) {
        const double at = state.theta_target[i];
        if (frozen[i] || !((at <= settings_.lower[i] && step[i] < 0) || (at >= settings_.upper[i] && step[i] > 0))) {
          continue;
        }
        frozen[i] = changed = true;
      }
      if (!changed) break;
      typename SmallSolve<M, double>::Matrix A;
      std::array<double, M> b = residual;
      for (int r = 0; r < M; ++r) {
        for (int c = 0; c <= r; ++c) {
          A[r][c] = r == c ? damping : 0;
          for (int i = 0; i < n; ++i) A[r][c] += frozen[i] ? 0 : J[r][i][1] * J[c][i][1];
        }
        for (int i = 0; i < n; ++i) {
          if (!frozen[i]) b[r] += J[r][i][1] * self_motion * (state.theta_target[i] - state.theta[i]);
        }
      }
      const auto y = SmallSolve<M, double>(A).solve(b);
      for (int i = 0; i < n; ++i) {
        step[i] = frozen[i] ? 0 : -self_motion * (state.theta_target[i] - state.theta[i]);
        for (int m = 0; m < M && !frozen[i]; ++m) step[i] += J[m][i][1] * y[m];
      }
    }
    for (int i = 0; i < n; ++i) largest = std::max(largest, std::abs(step[i]));
    return largest;
  }

  /// Lets gamma fall while the arm stalls, or has not come nearer to theta_T for long; it may rise again only when the
  /// arm is clearly nearer than where it stalled, and when the target has been waiting for long, less and less. So
  /// gamma goes to 0 unless the arm arrives before, and the joints' attractor alone brings it to theta_T.
  void schedule_gamma(bool slow, double distance, double hand_error, GuardedState& state) const {
    if (distance_between(state.last_target, state.awaited) > Tuning::kMovedAway * settings_.reach) {
      state.awaited = state.last_target;
      state.waited_steps = 0;
      state.ceiling = settings_.gamma;
    }
    if (hand_error < Tuning::kAtTarget * settings_.reach) forget_progress(state);
    if (distance < Tuning::kNearer * state.best_distance) {
      state.best_distance = distance;
      state.idle_steps = 0;
    } else if (state.idle_steps <= Tuning::kIdle) {
      ++state.idle_steps;
    }
    if (state.waited_steps < Tuning::kWait) {
      ++state.waited_steps;
    } else if (state.ceiling > Tuning::kLeastGamma) {
      state.ceiling *= Tuning::kCeilingDecay;
    }
    if (slow || state.idle_steps > Tuning::kIdle) {
      if (state.gamma > Tuning::kLeastGamma) state.gamma *= Tuning::kGammaDecay;
      state.stalled_distance = std::min(state.stalled_distance, distance);
    } else if (distance < Tuning::kPassed * state.stalled_distance) {
      state.gamma *= Tuning::kGammaRise;
    }
    state.gamma = std::min(state.gamma, state.ceiling);
  }

  /// theta_T is stuck when what it lacks does not fall, and is more than it may lag behind a target that moves.
  void watch_posture(double residual, GuardedState& state) const {
    state.residual = residual;
    if (++state.steps % Tuning::kWatch != 0) return;
    const double moved = distance_between(state.last_target, state.watched_target);
    state.posture_stuck =
        residual > std::max(Tuning::kReached, moved) && residual > Tuning::kNoProgress * state.watched_residual;
    state.watched_residual = residual;
    state.watched_target = state.last_target;
  }

  static double distance_between(const std::array<double, 3>& a, const std::array<double, 3>& b) {
    double sum = 0;
    for (size_t k = 0; k < 3; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
    return std::sqrt(sum);
  }

  Arm chain_;
  Eigen::Matrix3d tool_;
  GuardedSettings settings_;
  typename Arm::Hand hand_;
  bool has_rotation_ = false, moving_ = false;
};

}  // namespace multireach::controller
