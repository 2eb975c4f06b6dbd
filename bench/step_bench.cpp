// Time of one integration step of the guarded law, compared with alternatives.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainiksolvervel_wdls.hpp>
#include <limits>

#include "bench/arms.hpp"
#include "bench/kdl_chain.hpp"
#include "bench/plain_step.hpp"
#include "controller/batch/guarded_batch.hpp"
#include "controller/batch/paper_batch.hpp"
#include "controller/collision/proximity.hpp"
#include "controller/ik/multi_start.hpp"
#include "controller/law/guarded_law.hpp"
#include "numeric/instruction_set.hpp"
#include "numeric/random.hpp"

namespace multireach::bench {
namespace {

using controller::GuardedLaw;
using controller::TaskKind;
using controller::TaskTarget;

constexpr int kReaches = 64, kStepsPerReach = 300;

struct Reach {
  JointVector start, target_posture;
  TaskTarget target;
};

std::vector<Reach> reaches(const Chain& chain, TaskKind task) {
  const CounterRandom random(1);
  const auto posture = [&](uint64_t k) {
    JointVector theta(chain.size());
    for (int i = 0; i < chain.size(); ++i) {
      theta[i] =
          random.uniform(k * kMaxJoints + static_cast<uint64_t>(i), chain.sample_lower(i), chain.sample_upper(i));
    }
    return theta;
  };
  const controller::MultiStartIk search(chain);
  std::vector<Reach> all;
  for (uint64_t k = 0; k < kReaches; ++k) {
    Reach reach{posture(2 * k), posture(2 * k + 1), {}};
    const Eigen::Isometry3d X = chain.pose(reach.target_posture);
    reach.target = {
        .position = X.translation(), .task = task, .direction = X.linear().col(2), .orientation = X.linear()};
    reach.target_posture = search.best(reach.target, reach.start).theta;
    all.push_back(reach);
  }
  return all;
}

void guarded_step(benchmark::State& state, const Chain& chain, TaskKind task) {
  const std::vector<Reach> all = reaches(chain, task);
  GuardedLaw law(chain);
  int k = 0, left = 0;
  for (auto _ : state) {
    if (left == 0) {
      law.start(all[k].start);
      law.set_target(all[k].target, all[k].target_posture);
      k = (k + 1) % kReaches;
      left = kStepsPerReach;
    }
    law.step();
    --left;
  }
  benchmark::DoNotOptimize(law.theta().data());
  // Times each step separately to find the slow ones; reading the clock is part of these times.
  std::vector<double> times;
  for (const Reach& reach : all) {
    law.start(reach.start);
    law.set_target(reach.target, reach.target_posture);
    for (int step = 0; step < kStepsPerReach; ++step) {
      const auto begin = std::chrono::steady_clock::now();
      law.step();
      times.push_back(std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count());
    }
  }
  std::sort(times.begin(), times.end());
  state.counters["p99.9_ns"] = times[times.size() * 999 / 1000];
}

template <int N>
void plain_step_of(benchmark::State& state, const Chain& chain) {
  const std::vector<Reach> all = reaches(chain, TaskKind::kPosition);
  PlainStep<N> law(chain, GuardedLaw(chain).largest_gamma());
  int k = 0, left = 0;
  for (auto _ : state) {
    if (left == 0) {
      law.start(all[k].start, all[k].target_posture, all[k].target.position);
      k = (k + 1) % kReaches;
      left = kStepsPerReach;
    }
    law.step();
    --left;
  }
  benchmark::DoNotOptimize(law.theta().data());
}

void plain_step(benchmark::State& state, const Chain& chain) {
  plain_step_of<Eigen::Dynamic>(state, chain);
}
/// With the number of joints known at compile time.
void plain_fixed_step(benchmark::State& state, const Chain& chain) {
  chain.size() == 4 ? plain_step_of<4>(state, chain) : plain_step_of<7>(state, chain);
}

/// One step of one arm of a batch, with the named instruction set; the same reaches.
template <class Batch, class... Parameters>
void batch_step(benchmark::State& state, const Chain& chain, const std::string& set, const Parameters&... parameters) {
  if (!select_instruction_set(set)) {
    state.SkipWithError("this processor has not this instruction set");
    return;
  }
  const std::vector<Reach> all = reaches(chain, TaskKind::kPosition);
  constexpr int kArms = 32;
  Batch batch(chain, parameters..., kArms);
  int k = 0, left = 0;
  while (state.KeepRunningBatch(batch.size())) {  // each iteration counts as one step of every arm
    if (left == 0) {
      for (int a = 0; a < batch.size(); ++a) {
        batch.start(a, all[k].start, all[k].target.position, all[k].target_posture);
        k = (k + 1) % kReaches;
      }
      left = kStepsPerReach;
    }
    batch.step();
    --left;
  }
  benchmark::DoNotOptimize(&batch.block(0));
  select_instruction_set("");  // back to the widest
}
void guarded_batch(benchmark::State& state, const Chain& chain, const std::string& set) {
  batch_step<controller::GuardedBatch>(state, chain, set, controller::GuardedParameters{});
}
void paper_batch(benchmark::State& state, const Chain& chain, const std::string& set) {
  batch_step<controller::PaperBatch>(state, chain, set, controller::PaperParameters{},
                                     std::numeric_limits<double>::infinity());
}

void kdl_wdls(benchmark::State& state, const Chain& chain) {
  const KDL::Chain arm = kdl_chain(chain);
  KDL::ChainIkSolverVel_wdls solver(arm);
  solver.setLambda(0.01);
  const std::vector<Reach> all = reaches(chain, TaskKind::kPosition);
  KDL::JntArray q(arm.getNrOfJoints()), v(arm.getNrOfJoints());
  const KDL::Twist twist(KDL::Vector(0.1, 0.05, -0.1), KDL::Vector(0, 0.1, 0));
  int k = 0;
  for (auto _ : state) {
    q.data = all[k].start;
    k = (k + 1) % kReaches;
    solver.CartToJnt(q, twist, v);
    benchmark::DoNotOptimize(v.data.data());
  }
}

void kdl_lma(benchmark::State& state, const Chain& chain) {
  const KDL::Chain arm = kdl_chain(chain);
  KDL::ChainIkSolverPos_LMA solver(arm, Eigen::Matrix<double, 6, 1>(1, 1, 1, 0, 0, 0));
  const std::vector<Reach> all = reaches(chain, TaskKind::kPosition);
  KDL::JntArray q(arm.getNrOfJoints()), found(arm.getNrOfJoints());
  int k = 0;
  for (auto _ : state) {
    q.data = all[k].start;
    const Eigen::Vector3d& p = all[k].target.position;
    k = (k + 1) % kReaches;
    solver.CartToJnt(q, KDL::Frame(KDL::Vector(p.x(), p.y(), p.z())), found);
    benchmark::DoNotOptimize(found.data.data());
  }
}

/// A step with twenty obstacles around the arm, and with its links avoiding each other.
void guarded_step_among_obstacles(benchmark::State& state, const Chain& chain, double link_radius_m) {
  controller::GuardedParameters parameters;
  parameters.body.link_radius_m = link_radius_m;
  GuardedLaw law(chain, parameters);
  controller::Proximity proximity(chain, parameters.body);
  const std::vector<controller::Obstacle> obstacles = twenty_obstacles(chain);
  law.set_obstacles(obstacles);
  proximity.set_obstacles(obstacles);
  std::vector<Reach> all = reaches(chain, TaskKind::kPosition);
  std::erase_if(all, [&](const Reach& reach) {
    return proximity.clearance(reach.start) < 0.01 || proximity.clearance(reach.target_posture) < 0.01;
  });
  if (all.empty()) {
    state.SkipWithError("no reach is clear of obstacles");
    return;
  }
  size_t k = 0;
  int left = 0;
  for (auto _ : state) {
    if (left == 0) {
      law.start(all[k].start);
      law.set_target(all[k].target, all[k].target_posture);
      k = (k + 1) % all.size();
      left = kStepsPerReach;
    }
    law.step();
    --left;
  }
}

BENCHMARK_CAPTURE(guarded_step, hoap2_n4_m3, hoap2(), TaskKind::kPosition);
BENCHMARK_CAPTURE(plain_step, hoap2_n4_m3, hoap2());
BENCHMARK_CAPTURE(plain_fixed_step, hoap2_n4_m3, hoap2());
BENCHMARK_CAPTURE(guarded_batch, hoap2_n4_m3_AVX3, hoap2(), "AVX3");
BENCHMARK_CAPTURE(guarded_batch, hoap2_n4_m3_AVX2, hoap2(), "AVX2");
BENCHMARK_CAPTURE(guarded_batch, hoap2_n4_m3_SSE4, hoap2(), "SSE4");
BENCHMARK_CAPTURE(paper_batch, hoap2_n4_m3_AVX3, hoap2(), "AVX3");
BENCHMARK_CAPTURE(kdl_lma, hoap2_n4_m3, hoap2());
BENCHMARK_CAPTURE(guarded_step, n7_m3, seven_joints(), TaskKind::kPosition);
BENCHMARK_CAPTURE(plain_step, n7_m3, seven_joints());
BENCHMARK_CAPTURE(plain_fixed_step, n7_m3, seven_joints());
BENCHMARK_CAPTURE(guarded_batch, n7_m3_AVX3, seven_joints(), "AVX3");
BENCHMARK_CAPTURE(guarded_batch, n7_m3_AVX2, seven_joints(), "AVX2");
BENCHMARK_CAPTURE(guarded_step, n7_m5, seven_joints(), TaskKind::kPointing);
BENCHMARK_CAPTURE(guarded_step, n7_m6, seven_joints(), TaskKind::kPose);
BENCHMARK_CAPTURE(guarded_step_among_obstacles, hoap2_n4_m3, hoap2(), 0.02);
BENCHMARK_CAPTURE(guarded_step_among_obstacles, n7_m3, seven_joints(), 0.05);
BENCHMARK_CAPTURE(kdl_wdls, n7_m6, seven_joints());

}  // namespace
}  // namespace multireach::bench

BENCHMARK_MAIN();
