#include "controller/node/controller_node.hpp"

#include <cmath>
#include <cstdlib>
#include <multireach/controller_state_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/obstacles_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>
#include <stdexcept>

#include "runtime/channels.hpp"
#include "runtime/files.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach {
namespace {

constexpr int64_t kOtherClock = 1000000;  // us: a target further than this from the next tick has another clock

/// Reads the keys that only the law `guarded` has.
controller::GuardedParameters guarded_parameters_from(const Config& config, const Chain& chain,
                                                      controller::ReachOptions& options) {
  controller::GuardedParameters law;
  if (config.has("gamma_rad2_m2")) law.gamma = config.number("gamma_rad2_m2", 0, 1e12);
  law.gains.alpha = config.number("alpha_per_step", 1e-6, 1, law.gains.alpha);
  law.gains.beta = config.number("beta_per_step", 1e-6, 1, law.gains.beta);
  if (config.has("acceleration_rad_s2")) {
    const std::vector<double> limits = config.numbers("acceleration_rad_s2", chain.size());
    for (const double limit : limits) {
      if (!(limit > 0)) config.fail("acceleration_rad_s2", "a positive number for each joint");
    }
    law.acceleration = Eigen::Map<const Eigen::VectorXd>(limits.data(), chain.size());
  }
  law.body.link_radius_m = config.number("link_radius_m", 0, 10, law.body.link_radius_m);
  law.body.margin_m = config.number("margin_m", 0, 1, law.body.margin_m);
  law.body.self_collision = config.flag("self_collision", law.body.self_collision);
  const std::string task = config.choice("task", {"position", "pointing", "pose"}, "position");
  if (task == "position") return law;
  law.tool.orientation_length_m = config.number("orientation_length_m", 1e-6, 1e3, law.tool.orientation_length_m);
  const auto unit = [&](const char* key, int size) {
    const std::vector<double> values = config.numbers(key, size);
    Eigen::VectorXd vector = Eigen::Map<const Eigen::VectorXd>(values.data(), size);
    if (!(vector.norm() > 1e-3 && vector.norm() < 1e3)) config.fail(key, "a vector that is not zero");
    return Eigen::VectorXd(vector.normalized());
  };
  if (task == "pointing") {
    options.task = controller::TaskKind::kPointing;
    options.direction = unit("pointing_direction", 3);
    if (config.has("tool_axis")) law.tool.axis = unit("tool_axis", 3);
  } else {
    options.task = controller::TaskKind::kPose;
    const Eigen::VectorXd wxyz = unit("orientation_wxyz", 4);
    options.orientation = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).toRotationMatrix();
  }
  return law;
}

}  // namespace

controller::ReachOptions reach_options_from(const RobotConfig& robot) {
  controller::ReachOptions options;
  options.tick_us = robot.tick_us;
  const auto section = robot.section("controller");
  if (!section) return options;
  const Config& config = *section;
  if (config.choice("law", {"guarded", "paper"}, "guarded") == "paper") {
    controller::PaperParameters law;
    law.gamma = config.number("gamma_rad2_m2", 0, 1e12, law.gamma);
    law.gains.alpha = config.number("alpha_per_step", 1e-6, 1, law.gains.alpha);
    law.gains.beta = config.number("beta_per_step", 1e-6, 1, law.gains.beta);
    options.drift_m = config.number("drift_m", 1e-6, 1e3, options.drift_m);
    options.law = law;
  } else {
    options.law = guarded_parameters_from(config, robot.chain, options);
  }
  options.steps_per_tick = static_cast<int>(config.integer("steps_per_tick", 1, 1000, options.steps_per_tick));
  options.target.jump_m = config.number("jump_m", 1e-6, 1e3, options.target.jump_m);
  options.target.wander_m_per_root_s = config.number("wander_m_per_root_s", 0, 1e3, options.target.wander_m_per_root_s);
  options.lost_after_us =
      static_cast<int64_t>(config.number("lost_after_s", 0, 1e6, options.lost_after_us * 1e-6) * 1e6);
  const std::string on_target_lost =
      config.choice("on_target_lost", {"keep_target", "go_to_rest", "stop"}, "keep_target");
  if (on_target_lost == "go_to_rest") options.on_target_lost = controller::OnTargetLost::kGoToRest;
  if (on_target_lost == "stop") options.on_target_lost = controller::OnTargetLost::kStop;
  if (config.choice("feedback", {"open", "measured"}, "open") == "measured") {
    options.feedback = controller::Feedback::kMeasured;
  }
  options.disturbance_threshold = config.number("disturbance_threshold_rad", 0, 10, options.disturbance_threshold);
  if (config.has("rest_rad")) options.rest = posture_from(config, "rest_rad", robot.chain);
  options.ik.seed = static_cast<uint64_t>(config.integer("seed", 0, INT64_MAX, 1));
  config.finish({"target_name"});
  return options;
}

namespace {

controller::ReachController controller_from(const RobotConfig& robot) {
  const controller::ReachOptions options = reach_options_from(robot);
  try {
    return {robot.chain, options};
  } catch (const std::invalid_argument& error) {
    throw InputError(robot.file.file() + ": section 'controller': " + error.what());
  }
}

}  // namespace

ControllerNode::ControllerNode(const RobotConfig& robot)
    : controller_(controller_from(robot)), joint_names_(joint_names(robot.chain)), config_digest_(robot.digest) {
  const auto section = robot.section("controller");
  if (section && section->has("target_name")) target_name_ = section->text("target_name");
}

std::vector<std::string_view> ControllerNode::inputs() const {
  return {channel::kTarget, channel::kObstacles, channel::kRobotState};
}

Receipt ControllerNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox&) {
  if (channel == channel::kTarget) return receive_target(bytes);
  return channel == channel::kObstacles ? receive_obstacles(bytes) : receive_robot_state(bytes);
}

Receipt ControllerNode::receive_target(std::span<const uint8_t> bytes) {
  const auto message = take<target_t>(bytes);
  if (!message) return {};
  counters_.dropped += targets_.missing_before(message->sequence);
  const Eigen::Vector3d position = Eigen::Map<const Eigen::Vector3d>(message->position_m);
  const Eigen::Vector3d velocity = Eigen::Map<const Eigen::Vector3d>(message->velocity_m_s);
  const bool seen = message->status != target_t::STATUS_LOST;
  if (target_name_ && message->name != *target_name_) return {};
  if (!plausible_utime(message->utime) || (seen && !(position.allFinite() && velocity.allFinite()))) {
    ++counters_.refused;
    return {};
  }
  if (!controller_.started()) return {};
  const auto next = controller_.next_tick();
  if (!next && !seen) return {};  // the first target that is seen starts the ticks
  if (!target_name_) target_name_ = message->name;
  if (!next || std::abs(message->utime - *next) > kOtherClock) controller_.restart_grid(message->utime);
  const bool taken =
      controller_.observe({.utime = message->utime,
                           .seen = seen,
                           .position = position,
                           .velocity = velocity,
                           .covariance = Eigen::Map<const Eigen::Matrix3d>(&message->covariance_m2[0][0])});
  if (!taken) {
    ++counters_.refused;
    return {Receipt::Effect::kTaken, std::nullopt, message->sequence};  // it may have restarted the ticks
  }
  target_sequence_ = message->sequence;
  return {Receipt::Effect::kTaken, message->utime, message->sequence};
}

Receipt ControllerNode::receive_obstacles(std::span<const uint8_t> bytes) {
  const auto message = take<obstacles_t>(bytes);
  if (!message) return {};
  counters_.dropped += obstacles_.missing_before(message->sequence);
  std::vector<controller::Obstacle> obstacles;
  for (const obstacle_t& sent : message->obstacles) {
    using Shape = controller::Obstacle::Shape;
    controller::Obstacle obstacle;
    const double* wxyz = sent.orientation_wxyz;
    const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    const bool known = sent.shape >= obstacle_t::SPHERE && sent.shape <= obstacle_t::BOX;
    // A quaternion that is not of unit length becomes NaN, which the controller refuses.
    obstacle.shape = sent.shape == obstacle_t::BOX       ? Shape::kBox
                     : sent.shape == obstacle_t::CAPSULE ? Shape::kCapsule
                                                         : Shape::kSphere;
    obstacle.X_WO.linear() = std::abs(q.norm() - 1) < 1e-3 ? q.normalized().toRotationMatrix()
                                                           : Eigen::Matrix3d::Constant(std::nan("")).eval();
    obstacle.X_WO.translation() = Eigen::Map<const Eigen::Vector3d>(sent.position_m);
    obstacle.size = known ? Eigen::Map<const Eigen::Vector3d>(sent.size_m).eval() : Eigen::Vector3d::Zero().eval();
    obstacles.push_back(obstacle);
  }
  new_obstacles_ = std::move(obstacles);
  obstacles_sequence_ = message->sequence;
  return {Receipt::Effect::kReplaces, std::nullopt, message->sequence};
}

Receipt ControllerNode::receive_robot_state(std::span<const uint8_t> bytes) {
  const auto message = take<robot_state_t>(bytes);
  if (!message) return {};
  counters_.dropped += robot_states_.missing_before(message->sequence);
  const bool running = controller_.next_tick().has_value();
  if (running && controller_.options().feedback == controller::Feedback::kOpen) return {};
  const auto theta = from_fields(controller_.chain(), message->joint_name, message->joint_position);
  if (theta && (running ? controller_.observe_robot(*theta) : controller_.start(*theta))) {
    robot_state_sequence_ = message->sequence;
    // The first measurement during the run must not replace the robot state from which the arm started.
    const bool first = running && !measured_;
    measured_ = running;
    return {first ? Receipt::Effect::kTaken : Receipt::Effect::kReplaces, std::nullopt, message->sequence};
  }
  ++counters_.refused;
  return {};
}

void ControllerNode::tick(Outbox& out) {
  if (new_obstacles_) {
    counters_.refused += controller_.set_obstacles(*new_obstacles_);
    new_obstacles_.reset();
  }
  last_ = controller_.tick();
  joint_setpoint_t setpoint;
  setpoint.utime = last_.utime;
  setpoint.sequence = sequence_;
  setpoint.tick = last_.tick;
  setpoint.target_sequence = target_sequence_;
  setpoint.robot_state_sequence = robot_state_sequence_;
  setpoint.obstacles_sequence = obstacles_sequence_;
  setpoint.num_joints = controller_.chain().size();
  setpoint.joint_name = joint_names_;
  setpoint.joint_position = to_field(last_.theta);
  setpoint.joint_velocity = to_field(last_.velocity);
  send(out, channel::kJointSetpoint, setpoint);

  controller_state_t state;
  state.utime = last_.utime;
  state.sequence = sequence_++;
  state.tick = last_.tick;
  state.mode = static_cast<int8_t>(last_.mode);
  state.target_lost = last_.target_lost;
  state.target_unreachable = last_.target_unreachable;
  Eigen::Map<Eigen::Vector3d>(state.hand_position_m) = last_.x;
  Eigen::Map<Eigen::Vector3d>(state.hand_target_m) = last_.x_T;
  state.gamma_rad2_m2 = last_.gamma;
  state.condition_number = last_.condition_number;
  state.attractor_residual_m = last_.attractor_residual_m;
  state.ik_searches = last_.ik_searches;
  state.num_joints = setpoint.num_joints;
  state.joint_name = joint_names_;
  state.joint_position = setpoint.joint_position;
  state.target_joint_position = to_field(last_.theta_target);
  state.weight_rad2_m2 = to_field(last_.weights);
  send(out, channel::kControllerState, state);
}

std::string ControllerNode::state() const {
  if (!controller_.started()) return "waiting for the robot";
  if (!controller_.next_tick()) return "waiting for a target";
  std::string text;
  switch (last_.mode) {
    case controller::ReachMode::kWaiting:
      text = "waiting";
      break;
    case controller::ReachMode::kReaching:
      text = "reaching";
      break;
    case controller::ReachMode::kHolding:
      text = "holding";
      break;
    case controller::ReachMode::kResting:
      text = "resting";
      break;
  }
  if (last_.target_lost) text += ", target lost";
  if (last_.target_unreachable) text += ", target unreachable";
  return text;
}

}  // namespace multireach
