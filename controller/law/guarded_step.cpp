#include "controller/law/guarded_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "controller/qp/box_qp.hpp"
#include "controller/qp/soft_collision_qp.hpp"
#include "controller/qp/velocity_bounds.hpp"
#include "controller/task/task_rows.hpp"
#include "numeric/interval.hpp"

namespace multireach::controller {
namespace {

#include "controller/law/guarded_step.inl.hpp"

double distance_between(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  double sum = 0;
  for (size_t k = 0; k < 3; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(sum);
}

/// Accessor of one arm for GuardedStep, with N joints (0: any number) and a task of M rows. The values at theta and at
/// theta_T share one register.
template <int N, int M>
class OneArm {
 public:
  using Scalar = double;
  using Mask = bool;
  using Register = Double2;
  static constexpr int kRows = M, kRegisters = 1;
  static constexpr bool kDisturbed = true;
  static constexpr size_t kCapacity = N == 0 ? kMaxJoints : N;
  using Joints = std::array<double, kCapacity>;
  using Task = std::array<double, M>;
  using Rows = std::array<std::array<std::array<Double2, kCapacity>, M>, 1>;

  OneArm(const GuardedArm& arm, const TaskTarget& target, std::span<const ProximityPair> pairs, GuardedState& state)
      : arm_(arm), target_(target), pairs_(pairs), state_(state), moves_(!target.velocity.isZero(0)) {}

  const GuardedSettings& settings() const { return arm_.settings; }
  GuardedProgress<double>& progress() { return state_.progress; }
  int size() const { return N == 0 ? arm_.links.size : N; }

  static bool none() { return false; }
  static double get(double number) { return number; }
  static void put(double value, double& number) { number = value; }
  template <int>
  static Double2 in_register(double now, double goal) {
    return Double2{now, goal};
  }
  /// Multiplies the element of theta by gamma and leaves that of theta_T unchanged.
  template <int>
  static Double2 weighted(double gamma, Double2 both) {
    return Double2{gamma, 1} * both;
  }
  static double now(Double2 both) { return both[0]; }
  static double goal(Double2 both) { return both[1]; }
  static Joints now_joints(const std::array<std::array<Double2, kCapacity>, 1>& both, int n) {
    Joints joints;
    for (int i = 0; i < n; ++i) joints[i] = both[0][i][0];
    return joints;
  }
  static std::array<Joints, M> now_rows(const Rows& J, int n) {
    std::array<Joints, M> rows;
    for (int m = 0; m < M; ++m) {
      for (int i = 0; i < n; ++i) rows[m][i] = J[0][m][i][0];
    }
    return rows;
  }

  double gamma() const { return state_.gamma; }
  void set_slow(bool value) { state_.slow = value; }
  void set_gamma(double value) { state_.gamma = value; }
  double theta(int i) const { return state_.theta[i]; }
  double theta_target(int i) const { return state_.theta_target[i]; }
  double velocity(int i) const { return state_.velocity[i]; }
  double disturbance(int i) const { return state_.disturbance[i]; }
  double hand_velocity(int m) const { return state_.hand_velocity[m]; }
  void set_hand_velocity(int m, double value) { state_.hand_velocity[m] = value; }
  void set_joint(int i, double velocity, double theta, double theta_target) {
    state_.velocity[i] = velocity;
    state_.theta[i] = theta;
    state_.theta_target[i] = theta_target;
  }

  /// Whether the target is where it was in the step before. Updates last_target: call it once per step.
  bool target_rests() {
    bool rests = true;
    for (int k = 0; k < 3; ++k) {
      rests = rests && target_.position[k] == state_.last_target[k];
      state_.last_target[k] = target_.position[k];
    }
    return rests;
  }
  bool target_moves() const { return moves_; }
  double target_velocity(int k) const { return target_.velocity[k]; }
  bool target_fixed() const { return state_.target_fixed; }
  bool target_moved_away() {
    if (!(distance_between(state_.last_target, state_.awaited) > GuardedTuning::kMovedAway * settings().reach)) {
      return false;
    }
    state_.awaited = state_.last_target;
    return true;
  }
  double target_moved_since_check() {
    const double moved = distance_between(state_.last_target, state_.checked_target);
    state_.checked_target = state_.last_target;
    return moved;
  }

  /// Computes the task's Jacobian at theta and theta_T, and the task errors theta -> theta_T and theta_T -> target.
  void task(Rows& J, Task& error, Task& residual) {
    if (M > 3 && !state_.has_rotation) multireach::controller::update_kinematics(arm_, state_);
    const auto& hand = state_.hand;
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < size(); ++i) J[0][k][i] = hand.jacobian[k][i];
      error[k] = hand.position[k][1] - hand.position[k][0];
      residual[k] = target_.position[k] - hand.position[k][1];
    }
    if constexpr (M > 3) {
      const double length = settings().orientation_length;
      const Columns3 axes = rotation(0), target_axes = rotation(1);
      const auto turn = orientation_error<M>(axes, target_axes, length);
      const auto target_turn = orientation_error<M>(target_axes, goal_axes(target_, arm_.tool), length);
      for (int r = 0; r < M - 3; ++r) {
        for (int i = 0; i < size(); ++i) J[0][3 + r][i] = orientation_row<M>(hand, r, i, length);
        error[3 + r] = turn[r];
        residual[3 + r] = target_turn[r];
      }
    }
  }

  void update_kinematics() {
    std::array<Double2, kMaxJoints> both;
    for (int i = 0; i < size(); ++i) both[i] = Double2{state_.theta[i], state_.theta_target[i]};
    forward_kinematics<(M > 3)>(arm_.links, size(), both, state_.hand);
    state_.has_rotation = M > 3;
  }

  bool obstructed() const { return state_.obstructed; }
  /// Whether this joint velocity would shrink a clearance faster than allowed.
  bool obstructs(const Joints& velocity) {
    state_.obstructed = false;
    for (const ProximityPair& pair : pairs_) {
      double sum = settings().barrier_rate.slope * pair.clearance;
      for (int i = 0; i < size(); ++i) sum += pair.gradient[i] * velocity[i];
      if (sum < 0) state_.obstructed = true;
    }
    return state_.obstructed;
  }
  int avoid(const Rows& J, double gamma, const std::array<std::array<Double2, kCapacity>, 1>& wanted, const Task& hand,
            const Joints& lower, const Joints& upper, Joints& velocity) const {
    SoftCollisionQp<kCapacity> program{.n = size(),
                                       .rows = M,
                                       .gamma = gamma,
                                       .jacobian = {},
                                       .wanted = now_joints(wanted, size()),
                                       .hand = {},
                                       .lower = lower,
                                       .upper = upper,
                                       .pairs = pairs_,
                                       .rate = settings().barrier_rate.slope,
                                       .stiffness = SoftCollisionQp<kCapacity>::stiffness_of(settings().mobility)};
    std::ranges::copy(now_rows(J, size()), program.jacobian.begin());
    std::ranges::copy(hand, program.hand.begin());
    return program.solve(velocity);
  }

 private:
  Columns3 rotation(int configuration) const {
    Columns3 columns;
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 3; ++k) columns[c][k] = state_.hand.rotation[c][k][configuration];
    }
    return columns;
  }

  const GuardedArm& arm_;
  const TaskTarget& target_;
  std::span<const ProximityPair> pairs_;
  GuardedState& state_;
  bool moves_;
};

template <int N, int M>
int step_of(const GuardedArm& arm, const TaskTarget& target, std::span<const ProximityPair> pairs,
            GuardedState& state) {
  OneArm<N, M> one(arm, target, pairs, state);
  return GuardedStep<OneArm<N, M>>(one).step();
}

}  // namespace

void update_kinematics(const GuardedArm& arm, GuardedState& state) {
  std::array<Double2, kMaxJoints> both;
  for (int i = 0; i < arm.links.size; ++i) both[i] = Double2{state.theta[i], state.theta_target[i]};
  forward_kinematics<true>(arm.links, arm.links.size, both, state.hand);
  state.has_rotation = true;
}

void restart_schedule(const GuardedArm& arm, GuardedState& state) {
  GuardedProgress<double>& progress = state.progress;
  progress.best_distance = progress.stalled_distance = std::numeric_limits<double>::infinity();
  progress.idle_steps = progress.waited_steps = 0;
  state.gamma = progress.gamma_max = progress.gamma_ceiling = arm.settings.gamma;
}

int guarded_step(const GuardedArm& arm, const TaskTarget& target, std::span<const ProximityPair> pairs,
                 GuardedState& state) {
  // Loops over the joints are unrolled for the usual sizes of arms: a step then takes about a tenth less time. Each
  // size costs seconds of compiling.
  return with_rows(target.task, [&]<int M>() {
    switch (arm.links.size) {
      case 4:
        if constexpr (M == 3) return step_of<4, M>(arm, target, pairs, state);
        break;
      case 5:
        if constexpr (M <= 5) return step_of<5, M>(arm, target, pairs, state);
        break;
      case 6:
        return step_of<6, M>(arm, target, pairs, state);
      case 7:
        return step_of<7, M>(arm, target, pairs, state);
      default:
        break;
    }
    return step_of<0, M>(arm, target, pairs, state);
  });
}

bool needs_search(const GuardedArm& arm, const TaskTarget& target, bool target_unchanged, GuardedState& state) {
  OneArm<0, 3> one(arm, target, {}, state);
  return GuardedStep<OneArm<0, 3>>(one).needs_search(target_unchanged);
}

}  // namespace multireach::controller
