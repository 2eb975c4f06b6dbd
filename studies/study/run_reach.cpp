#include "studies/study/run_reach.hpp"

namespace multireach {
ReachResult run_guarded(controller::GuardedLaw& law, const ReachSample& sample, const ReachRules& rules) {
  law.start(sample.start);
  law.set_target({.position = sample.target}, sample.target_posture);
  ReachMonitor monitor(law.chain(), sample, rules, law.x());
  do {
    law.step();
  } while (monitor.update(law.theta(), law.velocity(), law.x()));
  return monitor.result();
}

ReachResult run_paper(const Chain& chain, const controller::PaperParameters& parameters,
                      const controller::MultiStartIk& search, double drift_m, const ReachSample& sample,
                      const ReachRules& rules) {
  controller::PaperState state = controller::paper_state_at_rest(chain, sample.start, sample.target_posture);
  ReachMonitor monitor(chain, sample, rules, state.x);
  do {
    controller::paper_step(chain, parameters, sample.target, Eigen::Vector3d::Zero(), state);
    if (!((sample.target - chain.position(state.theta_target)).norm() <= drift_m)) {
      if (const auto found = search.nearest(sample.target, state.theta)) state.theta_target = *found;
    }
  } while (monitor.update(state.theta, state.theta_dot, state.x));
  return monitor.result();
}

}  // namespace multireach
