// multireach-bench-worst: the longest integration steps of the guarded law while it must search other joint
// configurations or plan around obstacles, as a Markdown table.
#include <fmt/format.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "bench/arms.hpp"
#include "controller/law/guarded_law.hpp"
#include "numeric/random.hpp"

namespace multireach::bench {
namespace {

using controller::GuardedLaw;
using controller::TaskKind;
using controller::TaskTarget;

constexpr int kSteps = 800;           // of each reach
constexpr int kStepsPerTarget = 400;  // the target jumps after so many steps, and no search begins when it jumps
constexpr uint64_t kUnreachable = 7;  // every so many targets one is out of reach

/// CPU time of this thread, so that other load on the machine does not count.
double processor_microseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
}

JointVector random_posture(const Chain& chain, uint64_t k) {
  const CounterRandom random(1, k);
  JointVector theta(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    theta[i] = random.uniform(static_cast<uint64_t>(i), chain.sample_lower(i), chain.sample_upper(i));
  }
  return theta;
}

TaskTarget random_target(const Chain& chain, TaskKind task, uint64_t k) {
  const Eigen::Isometry3d X = chain.pose(random_posture(chain, k));
  TaskTarget target{
      .position = X.translation(), .task = task, .direction = X.linear().col(2), .orientation = X.linear()};
  if (k % kUnreachable == 0) {
    const Eigen::Vector3d shoulder = chain.fixed(0).translation();
    target.position = shoulder + 1.2 * chain.reach() * (target.position - shoulder).normalized();
  }
  return target;
}

/// Number and length of what takes several steps: searches, or plans.
struct Spread {
  int64_t count = 0, steps = 0, longest = 0, running = 0;

  void add(bool is_running, int64_t begun) {
    count += begun;
    running = is_running ? running + 1 : 0;
    steps += is_running ? 1 : 0;
    longest = std::max(longest, running);
  }
  std::string text() const {
    const double mean = count > 0 ? static_cast<double>(steps) / static_cast<double>(count) : 0;
    return fmt::format("{} | {:.0f} | {}", count, mean, longest);
  }
};

struct Seen {
  std::vector<double> us;  // the time of each step, the least of all passes
  Spread searches, plans;  // for theta_T; around obstructions
};

enum class Obstacles { kNone, kAround, kInTheWay };

/// The same reaches, once more: every pass takes the same steps, so what the machine adds differs and the rest does
/// not.
void pass(GuardedLaw& law, TaskKind task, Obstacles around, uint64_t reaches, Seen& seen) {
  const Chain& chain = law.chain();
  const bool first = seen.us.empty();
  if (first) seen.us.assign(reaches * kSteps, INFINITY);
  size_t at = 0;
  for (uint64_t k = 0; k < reaches; ++k) {
    law.start(random_posture(chain, 1000 * k + 1));
    const TaskTarget target = random_target(chain, task, 1000 * k + 2);
    if (around == Obstacles::kInTheWay) {
      std::vector<controller::Obstacle> obstacles = twenty_obstacles(chain);
      controller::Obstacle& sphere = obstacles.emplace_back();
      sphere.X_WO.translation() = 0.5 * (law.x() + target.position);
      sphere.size.setConstant(0.4 * (law.x() - target.position).norm());
      law.set_obstacles(obstacles);
    }
    law.set_target(target, random_posture(chain, 1000 * k + 3));
    int64_t searches = law.ik_searches();
    for (int step = 0; step < kSteps; ++step, ++at) {
      if (step > 0 && step % kStepsPerTarget == 0) {
        law.update_target(random_target(chain, task, 1000 * k + 3 + static_cast<uint64_t>(step / kStepsPerTarget)));
      }
      const double begin = processor_microseconds();
      law.step();
      seen.us[at] = std::min(seen.us[at], processor_microseconds() - begin);
      if (!first) continue;
      seen.searches.add(law.searching(), law.ik_searches() - searches);
      seen.plans.add(law.planning(), law.planning() && seen.plans.running == 0 ? 1 : 0);
      searches = law.ik_searches();
    }
  }
}

void measure(const std::string& name, const Chain& chain, TaskKind task, Obstacles around, uint64_t reaches,
             int passes) {
  controller::GuardedParameters parameters;
  if (around != Obstacles::kNone) parameters.body.link_radius_m = 0.06 * chain.reach();
  GuardedLaw law(chain, parameters);
  if (around == Obstacles::kAround) law.set_obstacles(twenty_obstacles(chain));
  Seen seen;
  for (int k = 0; k < passes; ++k) pass(law, task, around, reaches, seen);
  std::sort(seen.us.begin(), seen.us.end());
  const auto quantile = [&](double q) {
    return seen.us[static_cast<size_t>(q * static_cast<double>(seen.us.size() - 1))];
  };
  const char* obstacles = around == Obstacles::kNone     ? "0"
                          : around == Obstacles::kAround ? "20"
                                                         : "20 and 1 in the way";
  fmt::print("| {} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {} | {} |\n", name, task == TaskKind::kPose ? 6 : 3,
             obstacles, seen.us.back(), quantile(0.999), quantile(0.5), seen.searches.text(), seen.plans.text());
  std::fflush(stdout);
}

}  // namespace
}  // namespace multireach::bench

int main(int argc, char** argv) {
  using namespace multireach;
  using namespace multireach::bench;
  CLI::App app("The longest integration steps while the guarded law searches theta_T or plans, as a Markdown table.",
               "multireach-bench-worst");
  uint64_t reaches = 30;
  int passes = 7;
  app.add_option("--reaches", reaches, "reaches of each arm, of 800 steps and two targets")->capture_default_str();
  app.add_option("--passes", passes, "the time of a step is the least of so many passes")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  fmt::print(
      "| arm | m | obstacles | longest step, µs | 99.9th percentile | median | searches | steps of a search, mean | "
      "longest | plans | steps of a plan, mean | longest |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const ArmName& arm : default_arms()) {
    if (!std::filesystem::exists(arm.urdf)) {
      fmt::print(stderr, "multireach-bench-worst: {} is not here; its arm is left out\n", arm.urdf);
      continue;
    }
    const Chain chain = load(arm);
    measure(arm.name, chain, TaskKind::kPosition, Obstacles::kNone, reaches, passes);
    if (chain.size() >= 6) measure(arm.name, chain, TaskKind::kPose, Obstacles::kNone, reaches, passes);
    for (const Obstacles around : {Obstacles::kAround, Obstacles::kInTheWay}) {
      measure(arm.name, chain, TaskKind::kPosition, around, reaches, passes);
    }
  }
  return 0;
}
