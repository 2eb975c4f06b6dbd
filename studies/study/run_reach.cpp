#include "studies/study/run_reach.hpp"

namespace multireach {
ReachResult run_guarded(controller::GuardedLaw& law, const ReachSample& sample, const ReachRules& rules) {
  law.start(sample.start);
  law.set_target({.position = sample.target}, sample.target_posture);
  ReachMonitor watch(law.chain(), sample, rules, law.x());
  do {
    law.step();
  } while (watch.take(law.theta(), law.velocity(), law.x()));
  return watch.result();
}

ReachResult run_paper(const Chain& chain, const controller::PaperParameters& parameters,
                      const controller::MultiStartIk& search, double rechoose_m, const ReachSample& sample,
                      const ReachRules& rules) {
  controller::PaperState state = controller::paper_state_at_rest(chain, sample.start, sample.target_posture);
  ReachMonitor watch(chain, sample, rules, state.x);
  do {
    controller::paper_step(chain, parameters, sample.target, Eigen::Vector3d::Zero(), state);
    if (!((sample.target - chain.position(state.theta_target)).norm() <= rechoose_m)) {
      if (const auto found = search.nearest(sample.target, state.theta)) state.theta_target = *found;
    }
  } while (watch.take(state.theta, state.theta_dot, state.x));
  return watch.result();
}

}  // namespace multireach
