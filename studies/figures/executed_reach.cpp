#include "studies/figures/executed_reach.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "robot_bridge/bridge.hpp"
#include "robot_bridge/sim/mujoco_arm.hpp"

namespace multireach {
namespace {

/// Maps the joints of `chain` to those of the robot.
class ChainOfRobot {
 public:
  ChainOfRobot(const Chain& chain, const MujocoArm& robot) : chain_(chain), robot_(robot) {
    for (const Joint& joint : chain.joints()) {
      const auto& names = robot.joint_names();
      at_.push_back(static_cast<size_t>(std::ranges::find(names, joint.name) - names.begin()));
    }
  }

  Moment moment(double time) const {
    const std::vector<double> positions = robot_.positions(), velocities = robot_.velocities();
    JointVector theta(chain_.size()), velocity(chain_.size());
    for (int i = 0; i < chain_.size(); ++i) {
      theta[i] = positions[at_[static_cast<size_t>(i)]];
      velocity[i] = velocities[at_[static_cast<size_t>(i)]];
    }
    return moment_of(chain_, time, theta, velocity);
  }

 private:
  const Chain& chain_;
  const MujocoArm& robot_;
  std::vector<size_t> at_;
};

MujocoArm robot_at(const SceneArm& arm, const JointVector& start) {
  MujocoArmOptions options;
  for (int i = 0; i < arm.chain.size(); ++i) options.start[arm.chain.joint(i).name] = start[i];
  return MujocoArm(arm.urdf_xml, options);
}

}  // namespace

ExecutedReach execute(const SceneArm& arm, const controller::ReachOptions& options, const JointVector& start,
                      const Eigen::Vector3d& target, double seconds, const std::optional<TimedPush>& push) {
  MujocoArm robot = robot_at(arm, start);
  const ChainOfRobot joints(arm.chain, robot);
  controller::ReachController controller(arm.chain, options);
  // As on the paper's second computer, and without supervision: the figures push the arm as the paper does.
  robot_bridge::BridgeOptions bridge_options;
  bridge_options.setpoint_period_us = options.tick_us;
  bridge_options.shape = robot_bridge::BridgeOptions::Shape::kLinear;
  bridge_options.monitor = {.max_tracking_error = 1e3, .state_timeout_us = INT64_MAX, .robot_lost_us = INT64_MAX};
  robot_bridge::Bridge bridge(arm.chain, bridge_options);
  controller.start(start);
  controller.restart_grid(0);
  const auto rest = JointVector::Zero(arm.chain.size());
  if (!bridge.measured({.run = 1, .utime = 0, .theta = start, .velocity = rest}))
    throw std::invalid_argument("the bridge refuses the start");

  ExecutedReach executed;
  executed.arm.push_back(joints.moment(0));
  Moment first = executed.arm.front();
  first.theta_target = start;
  executed.setpoints.push_back(first);
  const auto milliseconds = static_cast<int64_t>(std::lround(seconds * 1e3));
  for (int64_t ms = 0; ms < milliseconds; ++ms) {
    const int64_t now = ms * 1000;
    if (controller.next_tick() == now) {
      controller.observe({.utime = now, .seen = true, .position = target});
      controller.observe_robot(executed.arm.back().theta);
      const controller::ReachOutput out = controller.tick();
      bool restarted = false;
      const auto verdict = bridge.setpoint(
          {.run = 1, .utime = now, .sequence = out.tick, .theta = out.theta, .velocity = out.velocity}, restarted);
      if (verdict != robot_bridge::SetpointVerdict::kAccepted)
        throw std::runtime_error(std::string("the bridge refuses a set-point: ") + name_of(verdict));
      Moment moment = moment_of(arm.chain, static_cast<double>(now + options.tick_us) * 1e-6, out.theta, out.velocity);
      moment.theta_target = out.theta_target;
      executed.setpoints.push_back(moment);
    }
    const robot_bridge::Command command = bridge.tick();
    for (int i = 0; i < arm.chain.size(); ++i) {
      robot.command(arm.chain.joint(i).name, command.theta[i], command.velocity[i]);
    }
    const double time = static_cast<double>(ms) * 1e-3;
    const bool pushed = push && time >= push->from_s && time < push->until_s;
    if (pushed && !robot.push(push->link, push->force_n)) throw std::invalid_argument("the push is none");
    if (!pushed) robot.release();
    robot.step();
    executed.arm.push_back(joints.moment(static_cast<double>(ms + 1) * 1e-3));
  }
  return executed;
}

}  // namespace multireach
