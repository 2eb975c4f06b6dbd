// multireach-bench-ik: compares inverse kinematics solvers on reachable targets, in the manner of Beeson & Ames,
// "TRAC-IK" (Humanoids 2015): share solved and time, for the project's solvers and Orocos KDL, as a Markdown table.
#include <fmt/format.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <optional>
#include <sstream>

#include "bench/arms.hpp"
#include "bench/ik_solvers.hpp"
#include "kinematics/urdf_chain.hpp"
#include "numeric/random.hpp"

namespace multireach::bench {
namespace {

using controller::TaskKind;
using controller::TaskTarget;

std::optional<ArmName> arm_named(const std::string& text) {
  const size_t tip = text.rfind(':'), base = tip == 0 || tip == std::string::npos ? tip : text.rfind(':', tip - 1);
  if (base == std::string::npos || tip == 0 || base == tip) return std::nullopt;
  const std::string urdf = text.substr(0, base);
  return ArmName{std::filesystem::path(urdf).stem().string(), urdf, text.substr(base + 1, tip - base - 1),
                 text.substr(tip + 1)};
}

/// The chain of an arm whose joints all turn, as the peers need it.
Chain load_turning(const ArmName& arm) {
  Chain chain = load(arm);
  const bool turns = std::all_of(chain.joints().begin(), chain.joints().end(),
                                 [](const Joint& joint) { return joint.type != Joint::Type::kPrismatic; });
  if (!turns) throw std::invalid_argument(arm.urdf + ": it has a sliding joint; the peers' arms only turn");
  return chain;
}

struct Score {
  int64_t solved = 0, inside = 0, both = 0;
  std::vector<double> microseconds, simulated_s;
};

double quantile(std::vector<double>& values, double q) {
  if (values.empty()) return 0;
  const auto at = static_cast<ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<size_t>(at)];
}

/// The hand pose at a random joint configuration, uniform inside the limits; the same as in `multireach-study --targets
/// postures` with the same seed.
TaskTarget target_number(const Chain& chain, uint64_t seed, uint64_t index, TaskKind task) {
  const CounterRandom random(seed, index);
  JointVector there(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    there[i] = random.uniform(kMaxJoints + static_cast<uint64_t>(i), chain.sample_lower(i), chain.sample_upper(i));
  }
  const Eigen::Isometry3d X = chain.pose(there);
  return {.position = X.translation(),
          .velocity = Eigen::Vector3d::Zero(),
          .task = task,
          .direction = X.linear().col(2),
          .orientation = X.linear()};
}

/// CPU time of this thread, so that other load on the machine does not count.
double processor_microseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
}

void measure(const std::string& name, const Chain& chain, TaskKind task, int64_t samples, uint64_t seed) {
  std::vector<IkSolver> solvers = own_solvers(chain);
  for (IkSolver& solver : kdl_solvers(chain, task)) solvers.push_back(std::move(solver));
  std::vector<Score> scores(solvers.size());
  JointVector middle(chain.size());
  for (int i = 0; i < chain.size(); ++i) middle[i] = 0.5 * (chain.sample_lower(i) + chain.sample_upper(i));
  for (int64_t k = 0; k < samples; ++k) {
    const TaskTarget target = target_number(chain, seed, static_cast<uint64_t>(k), task);
    // The order of the solvers rotates with every target, so that none always runs after the same other one (cache
    // effects).
    for (size_t s = 0; s < solvers.size(); ++s) {
      const size_t which = (s + static_cast<size_t>(k)) % solvers.size();
      const double begin = processor_microseconds();
      const IkAnswer answer = solvers[which].solve(target, middle);
      const double end = processor_microseconds();
      Score& score = scores[which];
      score.microseconds.push_back(end - begin);
      const JointVector posture = unwound(chain, answer.posture);
      const bool solved = meets(chain, target, posture), inside = inside_limits(chain, posture);
      score.solved += solved;
      score.inside += inside;
      score.both += solved && inside;
      if (solvers[which].moves && solved) score.simulated_s.push_back(answer.simulated_s);
    }
  }
  const double all = static_cast<double>(samples) / 100;
  for (size_t s = 0; s < solvers.size(); ++s) {
    Score& score = scores[s];
    const double mean = std::accumulate(score.microseconds.begin(), score.microseconds.end(), 0.0) /
                        static_cast<double>(score.microseconds.size());
    const std::string moving = solvers[s].moves ? fmt::format("{:.2f}, {:.2f}", quantile(score.simulated_s, 0.5),
                                                              quantile(score.simulated_s, 0.95))
                                                : "";
    fmt::print("| {} | {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.1f} | {:.1f} | {:.1f} | {} |\n", name,
               task == TaskKind::kPose ? 6 : 3, solvers[s].name, static_cast<double>(score.solved) / all,
               static_cast<double>(score.inside) / all, static_cast<double>(score.both) / all, mean,
               quantile(score.microseconds, 0.5), quantile(score.microseconds, 0.95), moving);
  }
  std::fflush(stdout);
}

int compare(const std::vector<ArmName>& arms, int64_t samples, uint64_t seed, bool skip_missing) {
  std::vector<std::pair<std::string, Chain>> chains;
  for (const ArmName& arm : arms) {
    if (skip_missing && !std::filesystem::exists(arm.urdf)) {
      fmt::print(stderr, "multireach-bench-ik: {} is not here; its arm is left out\n", arm.urdf);
    } else {
      chains.emplace_back(arm.name, load_turning(arm));
    }
  }
  fmt::print("{} targets for each arm, seed {}; processor time\n\n", samples, seed);
  fmt::print(
      "| arm | m | solver | solved, % | inside limits, % | both, % | mean, µs | median | 95 % | moving, s: median, 95 "
      "% "
      "|\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& [name, chain] : chains) {
    measure(name, chain, TaskKind::kPosition, samples, seed);
    if (chain.size() >= 6) measure(name, chain, TaskKind::kPose, samples, seed);
  }
  return 0;
}

}  // namespace
}  // namespace multireach::bench

int main(int argc, char** argv) {
  using namespace multireach::bench;
  CLI::App app("Inverse kinematics for reachable targets, beside Orocos KDL, as a Markdown table.",
               "multireach-bench-ik");
  std::vector<std::string> named;
  int64_t samples = 10000;
  uint64_t seed = 1;
  app.add_option("arms", named,
                 "URDF:BASE:TIP of each arm; default: the Hoap2, and those of ../shared/robots that are there");
  app.add_option("--samples", samples, "targets for each arm")
      ->check(CLI::Range(int64_t{1}, int64_t{100000000}))
      ->capture_default_str();
  app.add_option("--seed", seed, "of the targets")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  std::vector<ArmName> arms;
  for (const std::string& text : named) {
    const auto arm = arm_named(text);
    if (!arm) {
      fmt::print(stderr, "multireach-bench-ik: '{}' is no arm; expected URDF:BASE:TIP\n", text);
      return 2;
    }
    arms.push_back(*arm);
  }
  try {
    return compare(arms.empty() ? default_arms() : arms, samples, seed, arms.empty());
  } catch (const std::exception& error) {
    fmt::print(stderr, "multireach-bench-ik: {}\n", error.what());
    return 2;
  }
}
