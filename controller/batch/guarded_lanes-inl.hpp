// The guarded law's step for several arms side by side, one in each lane of a register: the operations of
// guarded_kernel_of.hpp, joint_bounds.hpp and box_program.hpp in the same order, with masks where those branch. So
// every arm gets the bits that it would get alone. For positions that rest; no body, no acceleration limits.
#if defined(MULTIREACH_CONTROLLER_GUARDED_LANES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MULTIREACH_CONTROLLER_GUARDED_LANES_INL_HPP
#undef MULTIREACH_CONTROLLER_GUARDED_LANES_INL_HPP
#else
#define MULTIREACH_CONTROLLER_GUARDED_LANES_INL_HPP
#endif

#include <limits>

#include "controller/batch/arm_block.hpp"
#include "controller/batch/box_lanes-inl.hpp"
#include "controller/batch/guarded_plan.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::controller {
namespace HWY_NAMESPACE {

/// N: the number of joints, or 0 for any.
template <int N>
class GuardedLanes {
 public:
  /// The arms `first` to first + kWidth - 1 of the block.
  GuardedLanes(const GuardedPlan& plan, GuardedBlock& block, int first)
      : plan_(plan), settings_(plan.settings), block_(block), first_(first) {}

  /// One step. Returns the arms whose theta_T should be chosen anew.
  LanesMask step() {
    const Lanes alpha = settings_.gains.alpha, beta = settings_.gains.beta, gamma = get(block_.gamma);
    Task error, residual, hand;
    for (int k = 0; k < 3; ++k) {
      const Lanes x_target = get(block_.x_target[k]), hand_velocity = get(block_.hand_velocity[k]);
      error[k] = x_target - get(block_.x[k]);
      residual[k] = get(block_.target[k]) - x_target;
      hand[k] = hand_velocity + alpha * (beta * error[k] - hand_velocity);
    }
    const Lanes residual2 = dot(residual, residual), damping = posture_damping(residual2);
    const Lanes self_motion = Tuning::kSelfMotion / get(block_.caution);
    Joints theta, theta_target, wanted, drawn, velocity, posture_step, lower, upper;
    Lanes apart2 = 0;
    for (int i = 0; i < n(); ++i) {
      theta[i] = get(block_.joints[i].theta);
      theta_target[i] = get(block_.joints[i].theta_target);
      const Lanes before = get(block_.joints[i].velocity), apart = theta_target[i] - theta[i];
      apart2 += apart * apart;
      wanted[i] = before + alpha * (beta * apart - before);
      drawn[i] = -self_motion * apart;
    }
    Rows J, J_T;
    for (int m = 0; m < 3; ++m) {
      for (int i = 0; i < n(); ++i) {
        J[m][i] = get(block_.joints[i].jacobian[m]);
        J_T[m][i] = get(block_.joints[i].jacobian_target[m]);
      }
    }
    const Task y = unbounded(n(), J, gamma, 1, wanted, hand);
    const Task y_T = unbounded(n(), J_T, 1, damping, drawn, residual);

    LanesMask bounded = no_lane(), blocked = no_lane();
    Lanes largest = 0, pull2 = 0;
    for (int i = 0; i < n(); ++i) {
      velocity[i] = wanted[i] + gamma * column(J, i, y);
      posture_step[i] = drawn[i] + column(J_T, i, y_T);
      range(i, theta[i], lower[i], upper[i]);
      bounded = bounded | (velocity[i] < lower[i]) | (velocity[i] > upper[i]);
      const Lanes next = theta_target[i] + posture_step[i];
      blocked = blocked | (next < settings_.lower[i]) | (next > settings_.upper[i]);
      largest = greater(largest, absolute(posture_step[i]));
      const Lanes pull = clamped(beta * (theta_target[i] - theta[i]), lower[i], upper[i]);
      pull2 += pull * pull;
    }
    if (any(bounded)) {
      BoxLanes<kCapacity>{n(), gamma, J, wanted, hand, lower, upper}.solve(y, bounded, velocity);
    }
    if (any(blocked)) {
      largest = unblocked(blocked, J_T, residual, damping, self_motion, theta, theta_target, posture_step);
    }
    const Lanes shrink = where(largest > Tuning::kLargestPostureStep, Tuning::kLargestPostureStep / largest, 1);

    for (int m = 0; m < 3; ++m) {
      Lanes sum = 0;
      for (int i = 0; i < n(); ++i) sum += J[m][i] * velocity[i];
      put(sum, block_.hand_velocity[m]);
    }
    Lanes speed2 = 0;
    for (int i = 0; i < n(); ++i) {
      const Lanes low = settings_.lower[i], high = settings_.upper[i];
      speed2 += velocity[i] * velocity[i];
      const LanesMask inside = (theta[i] >= low) & (theta[i] <= high);
      const Lanes next = theta[i] + velocity[i];
      theta[i] = where(inside, clamped(next, low, high), next);
      theta_target[i] = clamped(theta_target[i] + shrink * posture_step[i], low, high);
      put(velocity[i], block_.joints[i].velocity);
      put(theta[i], block_.joints[i].theta);
      put(theta_target[i], block_.joints[i].theta_target);
    }
    const LanesMask slow = speed2 < Tuning::kStalledBelow * Tuning::kStalledBelow * pull2;
    schedule_gamma(slow, square_root(apart2), square_root(dot(error, error)), gamma);
    watch_posture(square_root(residual2));
    place<N, false>(plan_.arm, block_, first_);
    place<N, true>(plan_.arm, block_, first_);
    return watch(theta, theta_target);
  }

 private:
  using Tuning = GuardedTuning;
  static constexpr size_t kCapacity = kRoom<N>;
  using Joints = HWY_NAMESPACE::Joints<kCapacity>;
  using Rows = HWY_NAMESPACE::Rows<kCapacity>;

  HWY_INLINE int n() const { return N == 0 ? plan_.arm.size : N; }
  HWY_INLINE Lanes get(const Row& row) const { return load(row, first_); }
  HWY_INLINE void put(Lanes value, Row& row) const { store(value, row, first_); }
  HWY_INLINE void put(LanesMask value, Row& row) const { store(where(value, 1, 0), row, first_); }
  HWY_INLINE LanesMask flag(const Row& row) const { return get(row) > 0; }

  /// velocity_range of joint_bounds.hpp.
  HWY_INLINE void range(int i, Lanes theta, Lanes& lower, Lanes& upper) const {
    const Lanes slope = settings_.barrier_rate.slope, speed = settings_.speed[i];
    const Lanes high = clamped(slope * (settings_.upper[i] - theta), -speed, speed);
    const Lanes low = clamped(-(slope * (theta - settings_.lower[i])), -speed, speed);
    lower = lesser(low, high);
    upper = greater(low, high);
  }

  HWY_INLINE Lanes posture_damping(Lanes residual2) {
    const double reach2 = settings_.reach * settings_.reach;
    const Lanes before = get(block_.residual), caution = get(block_.caution);
    LanesMask rests = get(block_.steps) > 0;
    LanesMask at_origin = get(block_.target[0]) == 0;
    for (int k = 1; k < 3; ++k) at_origin = at_origin & (get(block_.target[k]) == 0);
    rests = rests | at_origin;
    const LanesMask worse = rests & (residual2 > before * before) & (residual2 > Tuning::kReached * Tuning::kReached);
    const Lanes next = where(worse, lesser(caution * Tuning::kCautionRise, Tuning::kMostCaution),
                             greater(1, caution * Tuning::kCautionFall));
    put(next, block_.caution);
    return next *
           (Tuning::kFarDamping * lesser(reach2, Tuning::kNearDamping * residual2) + Tuning::kLeastDamping * reach2);
  }

  /// unblocked_posture_step of the kernel, for the arms of `blocked`.
  HWY_NOINLINE Lanes unblocked(LanesMask blocked, const Rows& J, const Task& residual, Lanes damping, Lanes self_motion,
                               const Joints& theta, const Joints& theta_target, Joints& step) const {
    std::array<LanesMask, kCapacity> frozen;
    for (int i = 0; i < n(); ++i) frozen[i] = no_lane();
    LanesMask active = blocked;
    for (int round = 0; round < n(); ++round) {
      LanesMask changed = no_lane();
      for (int i = 0; i < n(); ++i) {
        const LanesMask outward = ((theta_target[i] <= settings_.lower[i]) & (step[i] < 0)) |
                                  ((theta_target[i] >= settings_.upper[i]) & (step[i] > 0));
        const LanesMask more = active & outward & !frozen[i];
        frozen[i] = frozen[i] | more;
        changed = changed | more;
      }
      active = changed;
      if (!any(active)) break;
      Solve::Matrix A;
      Task b = residual;
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c <= r; ++c) A[r][c] = r == c ? damping : Lanes(0);
      }
      for (int i = 0; i < n(); ++i) {
        const Lanes apart = theta_target[i] - theta[i];
        for (int r = 0; r < 3; ++r) {
          for (int c = 0; c <= r; ++c) A[r][c] += where(frozen[i], 0, J[r][i] * J[c][i]);
          b[r] = where(frozen[i], b[r], b[r] + J[r][i] * self_motion * apart);
        }
      }
      const Task y = Solve(A).solve(b);
      for (int i = 0; i < n(); ++i) {
        Lanes next = -self_motion * (theta_target[i] - theta[i]);
        for (int m = 0; m < 3; ++m) next += J[m][i] * y[m];
        step[i] = where(active, where(frozen[i], 0, next), step[i]);
      }
    }
    Lanes largest = 0;
    for (int i = 0; i < n(); ++i) largest = greater(largest, absolute(step[i]));
    return largest;
  }

  HWY_INLINE void schedule_gamma(LanesMask slow, Lanes distance, Lanes hand_error, Lanes gamma) {
    const Lanes never = std::numeric_limits<double>::infinity(), most = get(block_.largest_gamma);
    const LanesMask there = hand_error < Tuning::kAtTarget * settings_.reach;
    Lanes best = where(there, never, get(block_.best_distance));
    Lanes stalled = where(there, never, get(block_.stalled_distance));
    Lanes idle = where(there, 0, get(block_.idle_steps)), waited = where(there, 0, get(block_.waited_steps));
    Lanes ceiling = where(there, most, get(block_.ceiling));

    const LanesMask nearer = distance < Tuning::kNearer * best;
    best = where(nearer, distance, best);
    idle = where(nearer, 0, where(idle <= Tuning::kIdle, idle + 1, idle));
    const LanesMask waits = waited < Tuning::kWait;
    waited = where(waits, waited + 1, waited);
    ceiling = where(!waits & (ceiling > Tuning::kLeastGamma), ceiling * Tuning::kCeilingDecay, ceiling);
    const LanesMask stalls = slow | (idle > Tuning::kIdle);
    const LanesMask falls = stalls & (gamma > Tuning::kLeastGamma);
    const LanesMask rises = !stalls & (distance < Tuning::kPassed * stalled);
    gamma = where(falls, gamma * Tuning::kGammaDecay, where(rises, gamma * Tuning::kGammaRise, gamma));
    stalled = where(stalls, lesser(stalled, distance), stalled);
    put(lesser(gamma, ceiling), block_.gamma);
    put(best, block_.best_distance);
    put(stalled, block_.stalled_distance);
    put(idle, block_.idle_steps);
    put(waited, block_.waited_steps);
    put(ceiling, block_.ceiling);
  }

  HWY_INLINE void watch_posture(Lanes residual) {
    const Lanes steps = get(block_.steps) + 1;
    put(steps, block_.steps);
    put(residual, block_.residual);
    const LanesMask looks = steps == Tuning::kWatch * rounded_down(steps * (1.0 / Tuning::kWatch));
    if (!any(looks)) return;
    // At the first look the target of the one before is the origin.
    Task target;
    for (int k = 0; k < 3; ++k) target[k] = get(block_.target[k]);
    const Lanes moved = where(steps == Tuning::kWatch, square_root(dot(target, target)), 0);
    const Lanes watched = get(block_.watched_residual);
    const LanesMask stuck = (residual > greater(Tuning::kReached, moved)) & (residual > Tuning::kNoProgress * watched);
    put((looks & stuck) | (!looks & flag(block_.posture_stuck)), block_.posture_stuck);
    put(where(looks, residual, watched), block_.watched_residual);
  }

  /// GuardedLaw::Parts::watch.
  HWY_INLINE LanesMask watch(const Joints& theta, const Joints& theta_target) {
    const Lanes steps = get(block_.steps);
    const LanesMask due = steps >= get(block_.quiet_until);
    if (!any(due)) return due;
    Lanes distance2 = 0;
    for (int i = 0; i < n(); ++i) {
      const Lanes apart = theta_target[i] - theta[i];
      distance2 += apart * apart;
    }
    const Lanes distance = square_root(distance2), before = get(block_.distance_at_choice);
    const Lanes least = where(due, lesser(before, distance), before);
    put(least, block_.distance_at_choice);
    const LanesMask out = flag(block_.out_of_reach), strayed = distance > Tuning::kStrayed * least + Tuning::kStrayedBy;
    const LanesMask needed = due & (strayed | (flag(block_.posture_stuck) & !out));
    const LanesMask rest = due & !needed;
    put(where(rest, steps + Tuning::kLookAgain, get(block_.quiet_until)), block_.quiet_until);
    put(out & !(rest & (get(block_.residual) < Tuning::kReached)), block_.out_of_reach);
    return needed;
  }

  const GuardedPlan& plan_;
  const GuardedSettings& settings_;
  GuardedBlock& block_;
  int first_;
};

}  // namespace HWY_NAMESPACE
}  // namespace multireach::controller
HWY_AFTER_NAMESPACE();

#endif
