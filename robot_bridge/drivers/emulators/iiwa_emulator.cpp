#include "robot_bridge/drivers/emulators/iiwa_emulator.hpp"

#include <drake/lcmt_iiwa_command.hpp>
#include <drake/lcmt_iiwa_status.hpp>
#include <limits>
#include <numbers>

#include "runtime/message.hpp"

namespace multireach::drivers {
namespace {

constexpr int64_t kStartTicks = 300;       // ms from the start of the driver to its first status, assumed
constexpr int64_t kSubscribedTicks = 100;  // ms from the start of the driver until it receives commands, assumed
constexpr int64_t kStepTicks = 5;          // ms: sendPeriod of the application for positions
constexpr int64_t kStartGuard = 250000;    // us: --start_command_guard
constexpr int64_t kUntimedStatuses = 200;
constexpr double kLimitMargin = std::numbers::pi / 180;  // rad, inside the position limits
constexpr double kServo = 120;                           // rad/s, assumed
constexpr double kRounding = 1e-9;                       // rad

std::vector<double> field(const JointVector& values) {
  return {values.begin(), values.end()};
}

}  // namespace

IiwaEmulator::IiwaEmulator(const Chain& chain, const JointVector& start)
    : chain_(chain), joints_(start), from_(start), to_(start) {}

void IiwaEmulator::end(const std::string& why) {
  if (!fault_.empty()) return;
  fault_ = why;
  joints_.stop();
}

void IiwaEmulator::restart() {
  fault_.clear();
  held_.reset();
  wanted_.reset();
  from_ = to_ = joints_.position;
  ticks_ = statuses_ = 0;
  first_status_us_.reset();
}

void IiwaEmulator::receive(size_t, std::span<const uint8_t> bytes, const Time& now, WireOutbox&) {
  const auto command = decode<drake::lcmt_iiwa_command>(bytes);
  if (!command || !fault_.empty() || command->utime == -1 || ticks_ < kSubscribedTicks) return;
  if (!first_status_us_) return end("a command before the first status");
  if (now.us - *first_status_us_ < kStartGuard) return end("a command within 0.25 s of the first status");
  if (command->num_joints != chain_.size() || command->num_torques != 0)
    return end("a command with a wrong number of joints");
  const JointVector wanted = Eigen::Map<const Eigen::VectorXd>(command->joint_position.data(), chain_.size());
  if (!wanted.allFinite()) return end("a command that is not finite");
  wanted_ = wanted.cwiseMax((chain_.lower().array() + kLimitMargin).matrix())
                .cwiseMin((chain_.upper().array() - kLimitMargin).matrix());
}

void IiwaEmulator::tick(const Time& now, WireOutbox& out) {
  if (fault_.empty() && ticks_ >= kStartTicks && ticks_ % kStepTicks == 0) step(now, out);
  const double share = static_cast<double>(ticks_ % kStepTicks + 1) / kStepTicks;
  if (fault_.empty()) joints_.follow(from_ + share * (to_ - from_), kServo, 1e-3);
  ++ticks_;
}

/// One FRI step: a status out, the newest command in.
void IiwaEmulator::step(const Time& now, WireOutbox& out) {
  const JointVector before = to_;
  if (!held_) held_ = joints_.position;
  if (wanted_) held_ = wanted_;
  from_ = before;
  to_ = *held_;
  const JointVector largest = 1e-3 * kStepTicks * chain_.velocity();
  if (((to_ - from_).cwiseAbs() - largest).maxCoeff() > kRounding)
    return end("a commanded step is faster than a joint's largest speed");
  if (!first_status_us_) first_status_us_ = now.us;
  drake::lcmt_iiwa_status status{};
  status.utime = statuses_++ < kUntimedStatuses ? -1 : now.wall_us;
  status.num_joints = chain_.size();
  const auto joints = static_cast<size_t>(chain_.size());
  status.joint_position_measured = field(joints_.position);
  status.joint_velocity_estimated = field(joints_.velocity);
  status.joint_position_commanded = field(to_);
  status.joint_position_ipo =
      wanted_ ? field(from_) : std::vector<double>(joints, std::numeric_limits<double>::quiet_NaN());
  status.joint_torque_measured = status.joint_torque_commanded = status.joint_torque_external =
      std::vector<double>(joints, 0.0);
  if (auto bytes = encode(status)) out.push_back({0, std::move(*bytes)});
}

}  // namespace multireach::drivers
