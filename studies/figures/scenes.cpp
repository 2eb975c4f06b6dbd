#include "studies/figures/scenes.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "controller/collision/proximity.hpp"
#include "controller/law/guarded_law.hpp"
#include "controller/law/paper_equations.hpp"
#include "controller/law/paper_law.hpp"
#include "controller/reach_controller.hpp"
#include "numeric/random.hpp"
#include "studies/figures/law_run.hpp"
#include "studies/study/reach_sample.hpp"
#include "studies/study/run_reach.hpp"

namespace multireach {
namespace {

using namespace controller;

constexpr uint64_t kSeed = 1;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// The first random reach whose result under the law `paper` satisfies `wanted`.
template <class Wanted>
ReachSample first_reach(const Chain& chain, const PaperParameters& paper, Wanted&& wanted) {
  const ReachSampler sampler(chain, kSeed);
  const MultiStartIk search(chain);
  for (uint64_t k = 0; k < 3000; ++k) {
    const ReachSample sample = sampler.sample(k);
    if (wanted(run_paper(chain, paper, search, 0.01, sample, {}))) return sample;
  }
  throw std::invalid_argument("no such reach was found among 3000");
}

double largest(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return values.cwiseAbs().maxCoeff();
}

double condition_at(const Chain& chain, const JointVector& theta, const JointVector& weights) {
  Eigen::Vector3d x;
  PositionJacobian jacobian;
  chain.position_and_jacobian(theta, x, jacobian);
  return condition_number(coherence_matrix(jacobian, weights));
}

}  // namespace

Table limits_scene(const Chain& chain) {
  const PaperParameters paper;
  const ReachSample sample =
      first_reach(chain, paper, [](const ReachResult& result) { return result.arrived && result.limit_excess > 0.1; });
  const double acceleration = 20;
  GuardedLaw law(chain, {.gamma = paper.gamma, .acceleration = JointVector::Constant(chain.size(), acceleration)});
  law.start(sample.start);
  law.set_target({.position = sample.target}, sample.target_posture);
  PaperState state = paper_state_at_rest(chain, sample.start, sample.target_posture);
  std::vector<PaperState> paper_path;
  int joint = 0;
  double worst = 0;
  for (int k = 0; k < 3 * kStepsPerSecond; ++k) {
    paper_path.push_back(state);
    for (int i = 0; i < chain.size(); ++i) {
      const double excess = std::max(state.theta[i] - chain.upper()[i], chain.lower()[i] - state.theta[i]);
      if (excess <= worst) continue;
      worst = excess;
      joint = i;
    }
    paper_step(chain, paper, sample.target, Eigen::Vector3d::Zero(), state);
  }
  Table table({"time", "paper", "guarded", "lower", "upper", "paper_speed", "guarded_speed", "largest_speed",
               "guarded_acceleration", "largest_acceleration"});
  double before = 0;
  for (size_t k = 0; k < paper_path.size(); ++k) {
    const double speed = law.velocity()[joint] * kStepsPerSecond;
    table.row({static_cast<double>(k) / kStepsPerSecond, paper_path[k].theta[joint], law.theta()[joint],
               chain.lower()[joint], chain.upper()[joint], paper_path[k].theta_dot[joint] * kStepsPerSecond, speed,
               chain.velocity()[joint], (speed - before) * kStepsPerSecond, acceleration});
    before = speed;
    law.step();
  }
  return table;
}

Table arrival_scene(const Chain& chain) {
  const PaperParameters paper{.gains = {}, .gamma = 1000};
  const ReachSample sample = first_reach(
      chain, paper, [](const ReachResult& result) { return !result.arrived && result.limit_excess < 1e-3; });
  GuardedLaw law(chain, {.gamma = paper.gamma});
  law.start(sample.start);
  law.set_target({.position = sample.target}, sample.target_posture);
  PaperState state = paper_state_at_rest(chain, sample.start, sample.target_posture);
  Table table({"time", "paper", "guarded", "gamma"});
  for (int k = 0; k < 8 * kStepsPerSecond; ++k) {
    table.row({k / kStepsPerSecond, (state.x - sample.target).norm(), (law.x() - sample.target).norm(), law.gamma()});
    law.step();
    paper_step(chain, paper, sample.target, Eigen::Vector3d::Zero(), state);
  }
  return table;
}

Table singularity_scene(const Chain& chain) {
  const PaperParameters paper;
  const JointVector start = hoap2_posture(chain, {0, 0, 0, 0}), goal = hoap2_posture(chain, {0, -90, 0, 0});
  const Eigen::Vector3d target = chain.position(goal);
  GuardedLaw law(chain, {.gamma = paper.gamma});
  law.start(start);
  law.set_target({.position = target});
  PaperState state = paper_state_at_rest(chain, start, law.theta_target());
  Table table({"time", "paper_distance", "guarded_distance", "paper_speed", "guarded_speed", "largest_speed",
               "guarded_condition", "bound_of_equation_32"});
  const double bound = 1 + paper.gamma * std::pow(chain.reach(), 2) * chain.size();
  for (int k = 0; k < 6 * kStepsPerSecond; ++k) {
    table.row({k / kStepsPerSecond, (state.x - target).norm(), (law.x() - target).norm(),
               largest(state.theta_dot) * kStepsPerSecond, largest(law.velocity()) * kStepsPerSecond,
               chain.velocity().maxCoeff(), condition_at(chain, law.theta(), law.weights()), bound});
    law.step();
    paper_step(chain, paper, target, Eigen::Vector3d::Zero(), state);
  }
  return table;
}

Table targets_scene(const Chain& chain) {
  const JointVector start = hoap2_posture(chain, {12, -17, -12, -52});
  const Eigen::Vector3d rest(0.12, -0.12, 0.10), elsewhere(0.06, -0.20, 0.08), far(0.30, -0.20, 0.05);
  ReachController controller(chain, {});
  controller.start(start);
  const CounterRandom random(kSeed);
  uint64_t counter = 0;
  int64_t frame = 0;
  Table table({"time", "target_x", "target_y", "target_z", "x", "y", "z", "distance", "speed"});
  controller.restart_grid(0);
  for (int64_t tick = 0; tick < 20 * 22; ++tick) {
    const int64_t now = tick * 50000;
    TargetObservation seen;
    for (; frame * 33333 <= now; ++frame) {
      const double t = static_cast<double>(frame) * 33333e-6;
      seen = {.utime = frame * 33333, .seen = true, .position = rest};
      if (t >= 3 && t < 9) {  // a circle, one turn in 3 s
        const double phase = 2 * std::numbers::pi * (t - 3) / 3, radius = 0.03, rate = 2 * std::numbers::pi / 3;
        seen.position += radius * Eigen::Vector3d(std::sin(phase), std::cos(phase) - 1, 0);
        seen.velocity = radius * rate * Eigen::Vector3d(std::cos(phase), -std::sin(phase), 0);
      } else if (t >= 9 && t < 11) {
        seen.position = elsewhere;
      } else if (t >= 11 && t < 14) {
        const double sigma = 0.004;
        seen.position = elsewhere;
        for (double& coordinate : seen.position) {  // the sum of twelve uniform numbers is nearly Gaussian
          double sum = -6;
          for (int k = 0; k < 12; ++k) sum += random.uniform(counter++);
          coordinate += sigma * sum;
        }
        seen.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
      } else if (t >= 14 && t < 16) {
        seen.seen = false;
      } else if (t >= 18 && t < 20) {
        seen.position = far;
      }
      controller.observe(seen);
    }
    const ReachOutput out = controller.tick();
    const Eigen::Vector3d target = seen.seen ? seen.position : Eigen::Vector3d::Constant(kNone);
    const Eigen::Vector3d target_then = target + 0.05 * seen.velocity;  // a set-point applies at the end of its tick
    table.row({static_cast<double>(now) * 1e-6, target.x(), target.y(), target.z(), out.x.x(), out.x.y(), out.x.z(),
               (out.x - target_then).norm(), largest(out.velocity)});
  }
  return table;
}

Table posture_choice_scene(const Chain& chain) {
  hoap2_posture(chain, {0, 0, 0, 0});
  // Try straight target paths through the reachable space until theta_T is searched again along one.
  const ReachSampler sampler(chain, kSeed);
  for (uint64_t line = 0; line < 2000; ++line) {
    const ReachSample from = sampler.sample(line), to = sampler.sample(line + 5000);
    GuardedLaw law(chain);
    law.start(from.target_posture);
    law.set_target({.position = from.target}, from.target_posture);
    Table table({"time", "theta_T_0", "theta_T_1", "theta_T_2", "theta_T_3", "theta_0", "theta_1", "theta_2", "theta_3",
                 "speed", "distance", "choices"});
    const Eigen::Vector3d velocity = (to.target - from.target) / (4 * kStepsPerSecond);
    bool reachable = true;
    double largest_jump = 0;
    JointVector before = law.theta_target();
    for (int k = 0; k < 7 * kStepsPerSecond; ++k) {
      const bool moving = k < 4 * kStepsPerSecond;
      const Eigen::Vector3d target = moving ? from.target + k * velocity : to.target;
      if (k % 7 == 0) {
        reachable = reachable &&
                    law.update_target({.position = target, .velocity = moving ? velocity : Eigen::Vector3d(0, 0, 0)}) !=
                        TargetResult::kUnreachable;
      }
      law.step();
      const auto &goal = law.theta_target(), &theta = law.theta();
      largest_jump = std::max(largest_jump, (goal - before).norm());
      before = goal;
      table.row({k / kStepsPerSecond, goal[0], goal[1], goal[2], goal[3], theta[0], theta[1], theta[2], theta[3],
                 largest(law.velocity()) * kStepsPerSecond, (law.x() - target).norm(),
                 static_cast<double>(law.ik_searches())});
    }
    if (largest_jump > 0.5 && reachable && (law.x() - to.target).norm() < 1e-4) return table;
  }
  throw std::invalid_argument("no such target path was found");
}

Table push_scene(const Chain& chain) {
  const JointVector start = hoap2_posture(chain, {12, -17, -12, -52});
  const Eigen::Vector3d target(0.10, -0.12, 0.10);
  constexpr int kPushed = 1;
  constexpr double kPush = -0.35;
  Table table({"time", "open_command", "measured_command", "arm", "open_distance", "measured_distance", "speed",
               "arm_distance"});
  std::vector<ReachController> controllers;
  for (const Feedback feedback : {Feedback::kOpen, Feedback::kMeasured}) {
    ReachOptions options;
    options.feedback = feedback;
    controllers.emplace_back(chain, options).start(start);
    controllers.back().restart_grid(0);
  }
  JointVector arm = start;
  for (int64_t tick = 0; tick < 20 * 6; ++tick) {
    const double t = static_cast<double>(tick) * 0.05;
    std::array<ReachOutput, 2> out;
    for (size_t c = 0; c < 2; ++c) {
      controllers[c].observe({.utime = tick * 50000, .seen = true, .position = target});
      controllers[c].observe_robot(arm);
      out[c] = controllers[c].tick();
    }
    table.row({t, out[0].theta[kPushed], out[1].theta[kPushed], arm[kPushed], (out[0].x - target).norm(),
               (out[1].x - target).norm(), largest(out[1].velocity), (chain.position(arm) - target).norm()});
    // The arm follows the controller with feedback; for one second, someone holds one joint away from its command.
    arm = out[1].theta;
    if (t >= 2 && t < 3) arm[kPushed] = start[kPushed] + kPush;
  }
  return table;
}

Table obstacle_scene(const Chain& chain) {
  const JointVector start = hoap2_posture(chain, {-51, -6, 17, -69}),
                    there = hoap2_posture(chain, {-51, -63, -17, -63});
  const GuardedParameters parameters{.body = {.link_radius_m = 0.02}};
  Obstacle wall{.shape = Obstacle::Shape::kBox, .size = {0.10, 0.01, 0.06}};
  wall.X_WO.translation() = 0.5 * (chain.position(start) + chain.position(there));
  Proximity proximity(chain, parameters.body);
  proximity.set_obstacles({&wall, 1});
  GuardedLaw around(chain, parameters), through(chain, parameters);
  around.set_obstacles({&wall, 1});
  for (GuardedLaw* law : {&around, &through}) {
    law->start(start);
    law->set_target({.position = chain.position(there)});
  }
  Table table({"time", "x", "y", "z", "clearance", "x_without", "y_without", "z_without", "clearance_without",
               "distance", "wall_x", "wall_y", "wall_z"});
  const Eigen::Vector3d middle = wall.X_WO.translation();
  for (int k = 0; k < 12 * kStepsPerSecond; ++k) {
    const Eigen::Vector3d x = around.x(), without = through.x();
    table.row({k / kStepsPerSecond, x.x(), x.y(), x.z(), proximity.clearance(around.theta()), without.x(), without.y(),
               without.z(), proximity.clearance(through.theta()), (x - chain.position(there)).norm(), middle.x(),
               middle.y(), middle.z()});
    around.step();
    through.step();
  }
  return table;
}

Table clutter_scene(const Chain& chain) {
  constexpr int kScenes = 300, kObstacles = 12, kTries = 2000;
  const double size = 0.1 * chain.reach();
  const GuardedParameters parameters{.body = {.link_radius_m = 0.06 * chain.reach()}};
  Proximity proximity(chain, parameters.body);
  GuardedLaw law(chain, parameters);
  Table table({"scene", "arrived", "least_clearance", "went_around", "limit_excess"});
  for (uint64_t scene = 0; scene < kScenes; ++scene) {
    const CounterRandom random(kSeed, scene);
    uint64_t counter = 0;
    std::vector<Obstacle> obstacles(kObstacles);
    for (size_t i = 0; i < kObstacles; ++i) {
      obstacles[i].shape = static_cast<Obstacle::Shape>(i % 3);
      for (double& coordinate : obstacles[i].size) coordinate = size;
      for (double& coordinate : obstacles[i].X_WO.translation()) {
        coordinate = random.uniform(counter++, -chain.reach(), chain.reach());
      }
      obstacles[i].X_WO.translation() += chain.fixed(0).translation();
    }
    proximity.set_obstacles(obstacles);
    const auto clear_posture = [&](JointVector& theta) {
      theta.resize(chain.size());
      for (int k = 0; k < kTries; ++k) {
        for (int i = 0; i < chain.size(); ++i) {
          theta[i] = random.uniform(counter++, chain.sample_lower(i), chain.sample_upper(i));
        }
        if (proximity.clearance(theta) > 0.01) return true;
      }
      return false;
    };
    JointVector start, there;
    if (!clear_posture(start) || !clear_posture(there)) continue;
    const Eigen::Vector3d target = chain.position(there);
    law.set_obstacles(obstacles);
    law.start(start);
    law.set_target({.position = target});
    double least = 1, excess = 0;
    bool around = false;
    for (int k = 0; k < 20 * kStepsPerSecond && (law.x() - target).norm() > 1e-5; ++k) {
      law.step();
      around = around || law.following_path();
      least = std::min(least, proximity.clearance(law.theta()));
      excess = std::max(excess, chain.limit_excess(law.theta()));
    }
    table.row(
        {static_cast<double>(scene), (law.x() - target).norm() < 1e-4 ? 1.0 : 0.0, least, around ? 1.0 : 0.0, excess});
  }
  return table;
}

Table orientation_scene(const Chain& chain) {
  if (chain.size() < 6) throw std::invalid_argument("this scene needs an arm of 6 joints or more");
  const CounterRandom random(kSeed);
  JointVector start(chain.size()), there(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    const double lower = chain.sample_lower(i), width = chain.sample_upper(i) - lower;
    start[i] = lower + width * random.uniform(static_cast<uint64_t>(i), 0.3, 0.7);
    there[i] = lower + width * random.uniform(static_cast<uint64_t>(i) + kMaxJoints, 0.3, 0.7);
  }
  const Eigen::Isometry3d goal = chain.pose(there);
  GuardedLaw pose(chain), pointing(chain);
  pose.start(start);
  pose.set_target({.position = goal.translation(), .task = TaskKind::kPose, .orientation = goal.linear()});
  pointing.start(start);
  pointing.set_target({.position = goal.translation(), .task = TaskKind::kPointing, .direction = goal.linear().col(2)});
  Table table({"time", "pose_distance", "pose_angle", "pointing_distance", "pointing_angle"});
  const auto distance = [&](const GuardedLaw& law) { return (law.x() - goal.translation()).norm(); };
  for (int k = 0; k < 6 * kStepsPerSecond; ++k) {
    const Eigen::Matrix3d R = chain.pose(pose.theta()).linear(), P = chain.pose(pointing.theta()).linear();
    table.row({k / kStepsPerSecond, distance(pose), Eigen::AngleAxisd(R.transpose() * goal.linear()).angle(),
               distance(pointing),
               std::atan2(P.col(2).cross(goal.linear().col(2)).norm(), P.col(2).dot(goal.linear().col(2)))});
    pose.step();
    pointing.step();
  }
  return table;
}

}  // namespace multireach
