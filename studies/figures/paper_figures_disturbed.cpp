// Figs. 15 and 16: reaches with disturbances.
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "studies/figures/executed_reach.hpp"
#include "studies/figures/law_run.hpp"
#include "studies/figures/scenes.hpp"

namespace multireach {
namespace {

using namespace controller;

constexpr double kGamma = 350;
constexpr double kDegrees = 180 / std::numbers::pi;

JointVector rest(const Chain& chain) {
  return hoap2_posture(chain, {12, -17, -12, -52});
}

/// The largest change of a joint's velocity in one step, between the moments `from` and `until`.
double velocity_step(const Motion& motion, size_t from, size_t until) {
  return largest_velocity_step(Motion(motion.begin() + static_cast<std::ptrdiff_t>(from),
                                      motion.begin() + static_cast<std::ptrdiff_t>(until + 1)));
}

}  // namespace

Figure displaced_scene(const SceneArm& arm) {
  const std::array<Eigen::Vector3d, 3> targets{{{0.10, -0.12, 0.10}, {0.10, -0.20, 0.08}, {0.12, -0.08, 0.04}}};
  const std::array<size_t, 4> steps{0, 42, 98, 420};  // target k is active from steps[k] on
  Figure figure{Table({"time", "paper_x", "paper_y", "paper_z", "paper_0", "paper_1", "paper_2", "paper_3", "guarded_x",
                       "guarded_y", "guarded_z", "guarded_0", "guarded_1", "guarded_2", "guarded_3", "target_x",
                       "target_y", "target_z"})};
  std::array<Motion, 2> motions;
  for (size_t i = 0; i < 2; ++i) {
    const std::string law = i == 0 ? "paper" : "guarded";
    const auto run = law_run(arm.chain, i == 0, kGamma, rest(arm.chain));
    Motion& motion = motions[i];
    motion.push_back(run->moment(0));
    for (size_t k = 0; k < 3; ++k) {
      run->set_target(targets[k]);
      for (size_t step = steps[k]; step < steps[k + 1]; ++step) {
        run->step();
        motion.push_back(run->moment(static_cast<double>(step + 1) / kStepsPerSecond));
      }
    }
    const auto undisturbed = law_run(arm.chain, i == 0, kGamma, rest(arm.chain));
    undisturbed->set_target(targets[0]);
    const Motion calm = record(*undisturbed, 3);
    figure.add(law, "largest joint speed", largest_joint_speed(motion), "rad/s");
    figure.add(law, "largest change of a joint's speed in a step; undisturbed reach", largest_velocity_step(calm),
               "rad/s");
    figure.add(law, "the same in the step after displacement 1", velocity_step(motion, steps[1], steps[1] + 1),
               "rad/s");
    figure.add(law, "the same in the step after displacement 2", velocity_step(motion, steps[2], steps[2] + 1),
               "rad/s");
    figure.add(law, "the same in the whole reach", largest_velocity_step(motion), "rad/s");
    figure.add(law, "maxima of the hand speed", speed_peaks(motion));
    figure.add(law, "within 1 mm after displacement 2",
               settled_after(motion, targets[2]) - static_cast<double>(steps[2]) / kStepsPerSecond, "s");
    figure.add(law, "hand to target at the end", 1e3 * (motion.back().x - targets[2]).norm(), "mm");
  }
  for (size_t step = 0; step <= steps[3]; step += 2) {
    std::vector<double> row{static_cast<double>(step) / kStepsPerSecond};
    for (const Motion& motion : motions) {
      append(row, motion[step].x, 100);
      append(row, motion[step].velocity);
    }
    const size_t now = step < steps[1] ? 0 : step < steps[2] ? 1 : 2;
    append(row, targets[now], 100);
    figure.curves.row(row);
  }
  return figure;
}

Figure pushed_scene(const SceneArm& arm) {
  const Eigen::Vector3d target(0.10, -0.12, 0.10);
  const JointVector start = rest(arm.chain), by = hoap2_posture(arm.chain, {15, -25, 10, 15});
  constexpr double kSeconds = 3.5, kPushed = 0.4;
  const TimedPush push{.link = "right_hand", .force_n = {0, -25, 0}, .from_s = kPushed, .until_s = kPushed + 0.25};
  Figure figure{
      Table({"time",        "displaced_x", "displaced_y", "displaced_z", "displaced_0", "displaced_1", "displaced_2",
             "displaced_3", "measured_x",  "measured_y",  "measured_z",  "measured_0",  "measured_1",  "measured_2",
             "measured_3",  "command_0",   "command_1",   "command_2",   "command_3",   "open_x",      "open_y",
             "open_z",      "calm_x",      "calm_y",      "calm_z"})};

  // As in the paper: displace the state itself, in one step.
  PaperRun displaced(arm.chain, {.gains = {}, .gamma = kGamma}, start);
  displaced.set_target(target);
  Motion motion = record(displaced, kPushed);
  const Eigen::Vector3d before = motion.back().x;
  motion.pop_back();
  displaced.displace(by);
  const Motion after = record(displaced, kSeconds - kPushed, kPushed);
  motion.insert(motion.end(), after.begin(), after.end());
  figure.add("paper; state displaced", "hand displaced by", 1e3 * (after.front().x - before).norm(), "mm");
  figure.add("paper; state displaced", "largest change of a joint's speed in a step", largest_velocity_step(motion),
             "rad/s");
  figure.add("paper; state displaced", "within 1 mm after the push began", settled_after(motion, target) - kPushed,
             "s");
  figure.add("paper; state displaced", "hand to target at the end", 1e3 * (motion.back().x - target).norm(), "mm");

  ReachOptions guarded;
  guarded.law = guarded_parameters(arm.chain, kGamma);
  ReachOptions measured = guarded, paper = guarded;
  measured.feedback = Feedback::kMeasured;
  paper.law = PaperParameters{.gains = {}, .gamma = kGamma};
  struct Loop {
    const char* name;
    const ReachOptions& options;
    ExecutedReach pushed, calm;
  };
  std::array<Loop, 3> loops{{{"paper; robot pushed; open", paper, {}, {}},
                             {"guarded; robot pushed; open", guarded, {}, {}},
                             {"guarded; robot pushed; measured", measured, {}, {}}}};
  for (Loop& loop : loops) {
    loop.pushed = execute(arm, loop.options, start, target, kSeconds, push);
    loop.calm = execute(arm, loop.options, start, target, kSeconds);
    double hand = 0, command = 0, behind = 0;
    for (size_t k = 0; k < loop.pushed.arm.size(); ++k) {
      hand = std::max(hand, (loop.pushed.arm[k].x - loop.calm.arm[k].x).norm());
    }
    for (size_t k = 0; k < loop.pushed.setpoints.size(); ++k) {
      const Moment& setpoint = loop.pushed.setpoints[k];
      command = std::max(command, (setpoint.theta - loop.calm.setpoints[k].theta).cwiseAbs().maxCoeff());
      const JointVector arm_then = moment_at(loop.pushed.arm, setpoint.time).theta;
      behind = std::max(behind, (arm_then - setpoint.theta).cwiseAbs().maxCoeff());
    }
    figure.add(loop.name, "hand displaced by", 1e3 * hand, "mm");
    figure.add(loop.name, "set-points changed by; largest joint", command * kDegrees, "°");
    figure.add(loop.name, "arm away from its set-point; largest joint", behind * kDegrees, "°");
    figure.add(loop.name, "largest change of a joint's speed in a tick of 50 ms",
               largest_velocity_step(loop.pushed.setpoints), "rad/s");
    figure.add(loop.name, "within 1 mm after the push began", settled_after(loop.pushed.arm, target) - kPushed, "s");
    figure.add(loop.name, "hand to target at the end", 1e3 * (loop.pushed.arm.back().x - target).norm(), "mm");
  }
  for (int k = 0; k <= 300; ++k) {
    const double time = 0.01 * k;
    std::vector<double> row{time};
    const Moment state = moment_at(motion, time), arm_now = moment_at(loops[2].pushed.arm, time);
    append(row, state.x, 100);
    append(row, state.theta, kDegrees);
    append(row, arm_now.x, 100);
    append(row, arm_now.theta, kDegrees);
    append(row, moment_at(loops[2].pushed.setpoints, time).theta, kDegrees);
    append(row, moment_at(loops[1].pushed.arm, time).x, 100);
    append(row, moment_at(loops[1].calm.arm, time).x, 100);
    figure.curves.row(row);
  }
  return figure;
}

}  // namespace multireach
