#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "controller/law/guarded_law.hpp"
#include "controller/law/paper_law.hpp"
#include "studies/study/reach_sample.hpp"

namespace multireach {

/// When a reach is over, and what counts as arrived.
struct ReachRules {
  double arrived_m = 1e-4;
  double settled_m = 1e-3;  ///< settled: stays nearer to the target than this
  double seconds = 20;      ///< a reach ends after this nominal time
  double excess = 1e-9;     ///< rad (m) or rad/s (m/s): a larger excess over a limit is a violation
  double steps_per_second = controller::kReferenceRate;
  double still = 1e-6;   ///< rad (m) per step: slower than this and within a tenth of arrived_m, a reach is over
  int rest_steps = 700;  ///< a reach is also over when the arm is still for more than so many steps, off target

  /// The same rules for another integration rate.
  static ReachRules at(double steps_per_second) {
    const controller::StepPace pace(steps_per_second);
    ReachRules rules;
    rules.steps_per_second = steps_per_second;
    rules.still *= pace.ratio;
    rules.rest_steps = pace.steps(rules.rest_steps);
    return rules;
  }
};

/// The result of one reach.
struct ReachResult {
  bool arrived = false, finite = true;
  double error_m = 0;          ///< at the end
  double limit_excess = 0;     ///< rad (m), the largest of all steps
  double velocity_excess = 0;  ///< rad/s (m/s), the largest of all steps
  double distance_m = 0;       ///< from the hand's start to the target
  double path_m = 0;           ///< length of the hand's path
  int64_t steps = 0;
  int64_t settled_step = -1;  ///< first step after which the hand stays within settled_m; -1 for never
};

/// |v|, summed in this order, so that batches give bit-identical results.
inline double length_of(const Eigen::Vector3d& v) {
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/// Evaluates a reach step by step.
class ReachMonitor {
 public:
  ReachMonitor(const Chain& chain, const ReachSample& sample, const ReachRules& rules, const Eigen::Vector3d& x)
      : chain_(chain), target_(sample.target), rules_(rules), last_x_(x) {
    result_.distance_m = length_of(x - target_);
    result_.error_m = result_.distance_m;
  }

  /// Evaluates the arm after one step; `velocity` is per step. Returns false when the reach is over.
  template <class Theta, class Velocity>
  bool update(const Theta& theta, const Velocity& velocity, const Eigen::Vector3d& x) {
    ++result_.steps;
    double fastest = 0, sum = x.sum();
    for (int i = 0; i < chain_.size(); ++i) {
      const double speed = std::abs(velocity[i]);
      fastest = std::max(fastest, speed);
      sum += theta[i] + speed;
      result_.limit_excess =
          std::max({result_.limit_excess, theta[i] - chain_.upper()[i], chain_.lower()[i] - theta[i]});
      result_.velocity_excess =
          std::max(result_.velocity_excess, speed * rules_.steps_per_second - chain_.velocity()[i]);
    }
    if (!std::isfinite(sum)) {
      result_.finite = false;
      result_.error_m = INFINITY;
      return false;
    }
    result_.path_m += length_of(x - last_x_);
    last_x_ = x;
    result_.error_m = length_of(x - target_);
    if (result_.error_m >= rules_.settled_m) {
      result_.settled_step = -1;
    } else if (result_.settled_step < 0) {
      result_.settled_step = result_.steps;
    }
    const bool still = fastest < rules_.still;
    still_steps_ = still ? still_steps_ + 1 : 0;
    if (still && result_.error_m < 0.1 * rules_.arrived_m) return false;
    if (still_steps_ > rules_.rest_steps) return false;
    return result_.steps < rules_.seconds * rules_.steps_per_second;
  }

  ReachResult result() {
    result_.arrived = result_.finite && result_.error_m <= rules_.arrived_m;
    return result_;
  }

 private:
  const Chain& chain_;
  Eigen::Vector3d target_;
  ReachRules rules_;
  Eigen::Vector3d last_x_;
  ReachResult result_;
  int still_steps_ = 0;
};

/// Runs a reach under the law `guarded`. `law` must have the sampler's chain; it is restarted.
ReachResult run_guarded(controller::GuardedLaw& law, const ReachSample& sample, const ReachRules& rules);

/// Runs a reach under the law `paper`. As in Sect. 3.4, theta_T is searched again when K(theta_T) is further than
/// `drift_m` from the target.
ReachResult run_paper(const Chain& chain, const controller::PaperParameters& parameters,
                      const controller::MultiStartIk& search, double drift_m, const ReachSample& sample,
                      const ReachRules& rules);

}  // namespace multireach
