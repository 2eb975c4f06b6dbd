#pragma once

#include <algorithm>
#include <cmath>

#include "controller/law/attractor_gains.hpp"
#include "controller/task/task_target.hpp"

namespace multireach::controller {

/// The guarded law's constants that depend on the integration rate, as values per step and numbers of steps. They are
/// tuned at kReferenceRate and converted, so that the motion is the same at any rate.
struct StepPace {
  StepPace() = default;
  explicit StepPace(double steps_per_second) : ratio(kReferenceRate / steps_per_second) {}

  double ratio = 1;  ///< the time of a step, in steps of 1 / kReferenceRate s
  // Step of theta_T
  double self_motion = remaining(0.05);   ///< fraction of theta - theta_T, along the self-motion, per step
  double max_target_step = ratio * 0.05;  ///< rad or m per step, of any joint
  double damping_rise = factor(4), damping_fall = factor(0.8);
  double check_every = steps(64);  ///< steps between two checks of its progress
  // Schedule of gamma
  double gamma_decay = factor(0.98), gamma_rise = factor(1.02), ceiling_decay = factor(0.99);
  double idle = steps(280), wait = steps(700);
  // Searching another theta_T
  double quiet = steps(140);      ///< smallest number of steps between two searches
  double look_again = steps(16);  ///< steps between two checks whether a search is needed
  /// Work of a search in one step, see MultiStartIk::begin(): at kReferenceRate some 20 us for an arm of seven joints.
  int search_work(TaskKind task) const { return steps_like(task == TaskKind::kPosition ? 48 : 24, ratio); }

  /// The number of steps, at least 1, in the time of `count` steps of 1 / kReferenceRate s.
  int steps(int count) const { return steps_like(count, 1 / ratio); }
  /// The factor per step that amounts to `each` per step of 1 / kReferenceRate s.
  double factor(double each) const { return ratio == 1 ? each : std::pow(each, ratio); }
  /// The fraction per step that amounts to `each` per step of 1 / kReferenceRate s, always of what remains.
  double remaining(double each) const { return ratio == 1 ? each : 1 - std::pow(1 - each, ratio); }

 private:
  static int steps_like(double count, double ratio) {
    return static_cast<int>(std::clamp(std::round(count * ratio), 1.0, 1e9));
  }
};

}  // namespace multireach::controller
