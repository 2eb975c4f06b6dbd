// multireach-bench-ik: compares inverse kinematics solvers on reachable targets, in the manner of Beeson & Ames,
// "TRAC-IK" (Humanoids 2015): share solved and time, for the project's solvers and Orocos KDL, as Markdown tables.
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
  int64_t solved = 0, both = 0;  // both: solved, and inside the limits
  std::vector<double> microseconds, simulated_s;
};

/// What every solver achieved for one arm and task.
struct Comparison {
  std::string arm;
  TaskKind task = TaskKind::kPosition;
  std::vector<IkSolver> solvers;
  std::vector<Score> scores;
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

Comparison measure(const std::string& name, const Chain& chain, TaskKind task, int64_t samples, uint64_t seed) {
  Comparison result{name, task, own_solvers(chain), {}};
  for (IkSolver& solver : kdl_solvers(chain, task)) result.solvers.push_back(std::move(solver));
  const std::vector<IkSolver>& solvers = result.solvers;
  result.scores.resize(solvers.size());
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
      Score& score = result.scores[which];
      score.microseconds.push_back(end - begin);
      const JointVector posture = unwound(chain, answer.posture);
      const bool solved = meets(chain, target, posture);
      score.solved += solved;
      score.both += solved && inside_limits(chain, posture);
      if (solvers[which].moves && solved) score.simulated_s.push_back(answer.simulated_s);
    }
  }
  fmt::print(stderr, "measured: {}, m = {}\n", name, task == TaskKind::kPose ? 6 : 3);
  return result;
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// A table with a row for each comparison and a column for each solver.
template <typename Cell>
void print_table(const char* title, std::vector<Comparison>& comparisons, Cell cell_of) {
  if (comparisons.empty()) return;
  fmt::print("\n## {}\n\n| arm | m |", title);
  for (const IkSolver& solver : comparisons.front().solvers) fmt::print(" {} |", solver.name);
  fmt::print("\n|---|---|");
  for (size_t s = 0; s < comparisons.front().solvers.size(); ++s) fmt::print("---|");
  fmt::print("\n");
  for (Comparison& each : comparisons) {
    fmt::print("| {} | {} |", each.arm, each.task == TaskKind::kPose ? 6 : 3);
    for (Score& score : each.scores) fmt::print(" {} |", cell_of(score));
    fmt::print("\n");
  }
}

/// A time with two digits below 10, whole above.
std::string short_time(double microseconds) {
  return microseconds < 9.95 ? fmt::format("{:.1f}", microseconds) : fmt::format("{:.0f}", microseconds);
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
  std::vector<Comparison> comparisons;
  for (const auto& [name, chain] : chains) {
    comparisons.push_back(measure(name, chain, TaskKind::kPosition, samples, seed));
    if (chain.size() >= 6) comparisons.push_back(measure(name, chain, TaskKind::kPose, samples, seed));
  }
  fmt::print("{} targets for each row, seed {}\n", samples, seed);
  const double per_cent = static_cast<double>(samples) / 100;
  print_table("Solved", comparisons, [&](const Score& score) {
    const double inside = static_cast<double>(score.both) / per_cent,
                 all = static_cast<double>(score.solved) / per_cent;
    return score.solved > score.both ? fmt::format("{:.2f} ({:.2f})", inside, all) : fmt::format("{:.2f}", inside);
  });
  print_table("Time", comparisons, [](Score& score) {
    return fmt::format("{}, {}, {}", short_time(mean(score.microseconds)),
                       short_time(quantile(score.microseconds, 0.5)), short_time(quantile(score.microseconds, 0.95)));
  });
  fmt::print("\n## Movement\n\n| arm | m | solver | median, s | 95 % |\n|---|---|---|---|---|\n");
  for (Comparison& each : comparisons) {
    for (size_t s = 0; s < each.solvers.size(); ++s) {
      if (!each.solvers[s].moves) continue;
      std::vector<double>& times = each.scores[s].simulated_s;
      fmt::print("| {} | {} | {} | {:.2f} | {:.2f} |\n", each.arm, each.task == TaskKind::kPose ? 6 : 3,
                 each.solvers[s].name, quantile(times, 0.5), quantile(times, 0.95));
    }
  }
  return 0;
}

}  // namespace
}  // namespace multireach::bench

int main(int argc, char** argv) {
  using namespace multireach::bench;
  CLI::App app("Inverse kinematics for reachable targets, beside Orocos KDL, as Markdown tables.",
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
