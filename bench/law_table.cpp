// multireach-bench-laws: the same reaches with the paper's law, the guarded law, and Orocos KDL, as a Markdown table.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainiksolvervel_wdls.hpp>

#include "bench/arms.hpp"
#include "bench/kdl_chain.hpp"
#include "controller/law/guarded_law.hpp"
#include "studies/study/run_reach.hpp"

namespace multireach::bench {
namespace {

using controller::ViteGains;

constexpr ViteGains kGains{0.08, 0.02};

/// KDL's LMA solves for the goal configuration (it ignores limits); the joint-space attractor moves there with the
/// guarded law's gains.
ReachResult run_lma(const Chain& chain, KDL::ChainIkSolverPos_LMA& solver, const ReachSample& sample) {
  KDL::JntArray start(static_cast<unsigned>(chain.size())), goal(start);
  start.data = sample.start;
  const Eigen::Vector3d& p = sample.target;
  const bool solved = solver.CartToJnt(start, KDL::Frame(KDL::Vector(p.x(), p.y(), p.z())), goal) >= 0;
  JointVector theta = sample.start, velocity = JointVector::Zero(chain.size());
  ReachMonitor monitor(chain, sample, {}, chain.position(theta));
  do {
    const JointVector apart = (solved ? JointVector(goal.data) : sample.start) - theta;
    velocity += kGains.alpha * (kGains.beta * apart - velocity);
    theta += velocity;
  } while (monitor.update(theta, velocity, chain.position(theta)));
  return monitor.result();
}

/// KDL's damped least squares converts a straight motion of the hand into joint velocities, step by step; `clamped`:
/// every joint stops at its limits.
ReachResult run_wdls(const Chain& chain, KDL::ChainIkSolverVel_wdls& solver, bool clamped, const ReachSample& sample) {
  KDL::JntArray q(static_cast<unsigned>(chain.size())), v(q);
  JointVector theta = sample.start;
  ReachMonitor monitor(chain, sample, {}, chain.position(theta));
  JointVector moved = JointVector::Zero(chain.size());
  do {
    const Eigen::Vector3d way = kGains.beta * (sample.target - chain.position(theta));
    q.data = theta;
    const bool solved = solver.CartToJnt(q, KDL::Twist(KDL::Vector(way.x(), way.y(), way.z()), KDL::Vector()), v) >= 0;
    const JointVector before = theta;
    if (solved) theta += v.data;
    if (clamped) theta = chain.clamped(theta);
    moved = theta - before;
  } while (monitor.update(theta, moved, chain.position(theta)));
  return monitor.result();
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const auto at = static_cast<ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<size_t>(at)];
}

void print_row(const char* name, const std::vector<ReachSample>& samples,
               const std::function<ReachResult(const ReachSample&)>& run) {
  int arrived = 0, beyond = 0, too_fast = 0, not_finite = 0;
  std::vector<double> ratios, settle;
  for (const ReachSample& sample : samples) {
    const ReachResult result = run(sample);
    arrived += result.arrived;
    beyond += result.limit_excess > 1e-9;
    too_fast += result.velocity_excess > 1e-9;
    not_finite += !result.finite;
    if (!result.arrived) continue;
    if (result.distance_m > 0.01) ratios.push_back(result.path_m / result.distance_m);
    settle.push_back(static_cast<double>(result.settled_step) / 140);
  }
  const double all = static_cast<double>(samples.size()) / 100;
  std::printf("| %s | %.2f | %.2f | %.2f | %.2f | %.3f | %.2f | %.2f |\n", name, arrived / all, beyond / all,
              too_fast / all, not_finite / all, quantile(ratios, 0.5), quantile(ratios, 0.95), quantile(settle, 0.95));
  std::fflush(stdout);
}

void compare(const ArmName& arm_name, int number) {
  const Chain chain = load(arm_name);
  const ReachSampler sampler(chain, 1);
  std::vector<ReachSample> samples;
  for (int k = 0; k < number; ++k) samples.push_back(sampler.sample(static_cast<uint64_t>(k)));

  std::printf(
      "## %s\n\n%s to %s, %d reaches, seed 1; per cent of all, and of those that arrived: path / distance, seconds\n\n",
      arm_name.name.c_str(), arm_name.base.c_str(), arm_name.tip.c_str(), number);
  std::printf(
      "| law | arrived | beyond a position limit | a speed limit | not finite | path p50 | p95 | settled p95 |\n");
  std::printf("|---|---|---|---|---|---|---|---|\n");
  const controller::MultiStartIk search(chain);
  for (const double gamma : {100.0, 350.0, 1000.0}) {
    const controller::PaperParameters paper{.gains = {}, .gamma = gamma};
    print_row(("paper, γ = " + std::to_string(static_cast<int>(gamma))).c_str(), samples,
              [&](const ReachSample& s) { return run_paper(chain, paper, search, 0.01, s, {}); });
  }
  for (const std::optional<double> gamma : {std::optional<double>{}, {350.0}, {10000.0}}) {
    controller::GuardedLaw law(chain, {.gamma = gamma});
    const std::string name =
        "guarded, γ = " + std::to_string(static_cast<int>(law.largest_gamma())) + (gamma ? "" : " (default)");
    print_row(name.c_str(), samples, [&](const ReachSample& s) { return run_guarded(law, s, {}); });
  }
  const KDL::Chain arm = kdl_chain(chain);
  KDL::ChainIkSolverPos_LMA lma(arm, Eigen::Matrix<double, 6, 1>(1, 1, 1, 0, 0, 0));
  print_row("KDL LMA, then the joints' attractor", samples,
            [&](const ReachSample& s) { return run_lma(chain, lma, s); });
  if (chain.size() >= 6) {
    KDL::ChainIkSolverVel_wdls wdls(arm);
    wdls.setLambda(0.05);
    Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(6, 6);
    weights.topLeftCorner(3, 3).setIdentity();
    wdls.setWeightTS(weights);
    print_row("KDL wdls", samples, [&](const ReachSample& s) { return run_wdls(chain, wdls, false, s); });
    print_row("KDL wdls, stopped at the limits", samples,
              [&](const ReachSample& s) { return run_wdls(chain, wdls, true, s); });
  }
  std::printf("\n");
}

}  // namespace
}  // namespace multireach::bench

int main(int argc, char** argv) {
  using namespace multireach::bench;
  CLI::App app("The same reaches under the paper's law, the guarded law, and Orocos KDL, as Markdown tables.");
  std::string urdf, base, tip;
  int samples = 0;
  CLI::Option* arm =
      app.add_option("--urdf", urdf, "URDF file; default: the Hoap2 and the iiwa 14 of ../shared/robots");
  app.add_option("--base", base, "link at the start of the chain")->needs(arm);
  app.add_option("--tip", tip, "link at the end of the chain")->needs(arm);
  app.add_option("--samples", samples, "reaches; default: 10000 of the Hoap2, 2000 of another arm")
      ->check(CLI::Range(1, 100000000));
  CLI11_PARSE(app, argc, argv);
  const std::vector<ArmName> known = default_arms();
  std::vector<ArmName> arms{known[0], known[2]};
  if (!urdf.empty()) arms = {{std::filesystem::path(urdf).stem().string(), urdf, base, tip}};
  try {
    for (const ArmName& each : arms) compare(each, samples > 0 ? samples : each.name == "Hoap2" ? 10000 : 2000);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "multireach-bench-laws: %s\n", error.what());
    return 2;
  }
  return 0;
}
