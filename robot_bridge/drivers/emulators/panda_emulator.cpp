#include "robot_bridge/drivers/emulators/panda_emulator.hpp"

#include <drake/lcmt_panda_command.hpp>
#include <drake/lcmt_panda_status.hpp>

#include "runtime/message.hpp"

namespace multireach::drivers {
namespace {

constexpr double kDt = 1e-3;               // s
constexpr double kFilterGain = 0.16;       // per ms: libfranka's low-pass filter at 30 Hz
constexpr int64_t kStartTicks = 300;       // ms until the first status, assumed
constexpr int64_t kSubscribedTicks = 100;  // ms until commands are received, assumed
constexpr int64_t kExpires = 100000;       // us: --expire_sec
constexpr double kServo = 200;             // rad/s, assumed
constexpr double kTolerance = 1e-3;        // of a limit, for rounding

std::vector<double> field(const JointVector& values) {
  return {values.begin(), values.end()};
}

bool exceeds(const JointVector& values, const JointVector& limits) {
  return (values.cwiseAbs() - (1 + kTolerance) * limits).maxCoeff() > 0;
}

}  // namespace

PandaEmulator::PandaEmulator(const Chain& chain, const JointVector& start, const PandaEmulatorOptions& options)
    : chain_(chain), options_(options), limits_(franka_limits(options.model)), joints_(start) {
  restart();
}

void PandaEmulator::end(const std::string& why) {
  if (!fault_.empty()) return;
  fault_ = why;
  joints_.stop();
}

void PandaEmulator::restart() {
  fault_.clear();
  wanted_.reset();
  joints_.stop();
  desired_ = joints_.position;
  velocity_ = acceleration_ = JointVector::Zero(chain_.size());
  ticks_ = 0;
}

void PandaEmulator::receive(size_t, std::span<const uint8_t> bytes, const Time&, WireOutbox&) {
  const auto command = decode<drake::lcmt_panda_command>(bytes);
  if (!command || !fault_.empty() || ticks_ < kSubscribedTicks) return;
  if (command->control_mode_expected != drake::lcmt_panda_command::CONTROL_MODE_POSITION)
    return end("a command of another control mode");
  if (command->num_joint_position != chain_.size() || command->num_joint_velocity != 0 ||
      command->num_joint_torque != 0)
    return end("a command with other arrays than joint positions");
  const JointVector wanted = Eigen::Map<const Eigen::VectorXd>(command->joint_position.data(), chain_.size());
  if (!wanted.allFinite()) return end("a command that is not finite");
  wanted_ = wanted;
  wanted_utime_ = command->utime;
}

void PandaEmulator::tick(const Time& now, WireOutbox& out) {
  if (fault_.empty() && ++ticks_ > kStartTicks) {
    control(now);
    if (fault_.empty()) joints_.follow(desired_, kServo, kDt);
    if (fault_.empty()) send_status(now, out);
  }
}

// The Research 3 allows less towards its position limits.
JointVector PandaEmulator::fastest(bool upwards) const {
  if (options_.model == FrankaModel::kPanda) return chain_.velocity();
  return chain_.velocity().cwiseMin(research3_velocity(desired_, upwards));
}

void PandaEmulator::control(const Time& now) {
  const bool expired = !wanted_ || wanted_utime_ < now.wall_us - kExpires || wanted_utime_ > now.wall_us + kExpires;
  // The filter starts from the robot's last set-point, after the limiter.
  const JointVector target = expired ? desired_ : *wanted_;
  const JointVector wanted_velocity = kFilterGain / kDt * (target - desired_);
  JointVector velocity = wanted_velocity;
  if (options_.limit_rate) {
    // Each limit of libfranka's limiter: jerk, then acceleration, which near the speed limit falls to 0.
    const JointVector up = fastest(true), down = fastest(false);
    for (int i = 0; i < velocity.size(); ++i) {
      const double most = limits_.jerk[i] * kDt, a_max = limits_.acceleration[i];
      const double wanted = (wanted_velocity[i] - velocity_[i]) / kDt;
      double acceleration = std::clamp(wanted, acceleration_[i] - most, acceleration_[i] + most);
      const double slope = limits_.jerk[i] / a_max;
      acceleration = std::min({acceleration, slope * (up[i] - velocity_[i]), a_max});
      acceleration = std::max({acceleration, -slope * (down[i] + velocity_[i]), -a_max});
      velocity[i] = velocity_[i] + acceleration * kDt;
    }
  }
  const JointVector acceleration = (velocity - velocity_) / kDt;
  const JointVector jerk = (acceleration - acceleration_) / kDt;
  check(velocity, acceleration, jerk);
  if (!fault_.empty()) return;
  desired_ += kDt * velocity;
  velocity_ = velocity;
  acceleration_ = acceleration;
}

void PandaEmulator::check(const JointVector& velocity, const JointVector& acceleration, const JointVector& jerk) {
  if (chain_.limit_excess(desired_) > 0) return end("joint_motion_generator_position_limits_violation");
  const JointVector rounding = kTolerance * chain_.velocity();
  if (((velocity - fastest(true) - rounding).array() > 0).any() ||
      ((-velocity - fastest(false) - rounding).array() > 0).any())
    return end("joint_motion_generator_velocity_limits_violation");
  if (exceeds(acceleration, limits_.acceleration)) return end("joint_motion_generator_velocity_discontinuity");
  if (!options_.limit_rate && exceeds(jerk, limits_.jerk))
    return end("joint_motion_generator_acceleration_discontinuity");
}

void PandaEmulator::send_status(const Time& now, WireOutbox& out) const {
  drake::lcmt_panda_status status{};
  status.utime = now.wall_us;
  status.num_joints = chain_.size();
  status.joint_position = field(joints_.position);
  status.joint_position_desired = field(desired_);
  status.joint_velocity = field(joints_.velocity);
  status.joint_velocity_desired = field(velocity_);
  status.joint_acceleration_desired = field(acceleration_);
  status.joint_torque = status.joint_torque_desired = status.joint_torque_external =
      std::vector<double>(static_cast<size_t>(chain_.size()), 0.0);
  status.control_command_success_rate = 1;
  status.robot_mode = wanted_ ? drake::lcmt_panda_status::MOVE : drake::lcmt_panda_status::IDLE;
  status.robot_utime = now.us;
  if (auto bytes = encode(status)) out.push_back({0, std::move(*bytes)});
}

}  // namespace multireach::drivers
