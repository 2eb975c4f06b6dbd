#include "robot_bridge/drivers/panda_driver.hpp"

#include <drake/lcmt_panda_command.hpp>
#include <drake/lcmt_panda_status.hpp>

#include "runtime/message.hpp"

namespace multireach::drivers {
namespace {

constexpr int64_t kStartGuard = 100000;  // us: statuses must keep coming before anything is sent
constexpr int64_t kPause = 30000;        // us, 30 statuses
constexpr int64_t kSilence = 100000;     // us: drake-franka-driver has ended

using Status = drake::lcmt_panda_status;

JointVector vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace

void PandaDriver::receive(size_t, std::span<const uint8_t> bytes, const Time& now, WireOutbox&) {
  const auto status = decode<Status>(bytes);
  if (!status) return;
  Reading reading{vector_of(status->joint_position), vector_of(status->joint_velocity),
                  vector_of(status->joint_torque)};
  // Each status has its time here: commands need it.
  if (!statuses_.accepts(status->utime < 0 ? INT64_MIN : status->utime, reading.position, reading.velocity, now.us))
    return;
  if (!first_status_us_) first_status_us_ = now.us;
  heard_us_ = now.us;
  robot_mode_ = status->robot_mode;
  robot_clock_us_ = status->utime;
  reading_ = std::move(reading);
}

void PandaDriver::tick(const Time& now, WireOutbox&) {
  if (heard_us_ && now.us - *heard_us_ > kSilence) {
    first_status_us_.reset();
    statuses_.forget();
  }
  const bool obeys = robot_mode_ == Status::IDLE || robot_mode_ == Status::MOVE;
  ready_ = first_status_us_ && obeys && now.us - *first_status_us_ > kStartGuard && now.us - *heard_us_ < kPause;
  was_ready_ |= ready_;
}

void PandaDriver::command(const JointVector& position, const JointVector&, int64_t, const Time& now, WireOutbox& out) {
  if (!ready_) return;
  drake::lcmt_panda_command command{};
  command.utime = robot_clock_us_ + (now.us - *heard_us_);
  command.num_joint_position = joints_;
  command.joint_position.assign(position.begin(), position.end());
  command.control_mode_expected = drake::lcmt_panda_command::CONTROL_MODE_POSITION;
  if (auto bytes = encode(command)) out.push_back({0, std::move(*bytes)});
}

DriverStatus PandaDriver::status() const {
  using Phase = DriverStatus::Phase;
  if (statuses_.only_others() && !was_ready_)
    return {Phase::kWaiting, "PANDA_STATUS has another number of joints than robot.yaml"};
  if (ready_) return {Phase::kReady, "ready"};
  if (!first_status_us_) {
    return was_ready_ ? DriverStatus{Phase::kFault,
                                     "PANDA_STATUS has ended: clear the error in Desk and restart "
                                     "drake-franka-driver"}
                      : DriverStatus{Phase::kWaiting, "waiting for PANDA_STATUS of drake-franka-driver"};
  }
  switch (robot_mode_) {
    case Status::REFLEX:
      return {Phase::kFault, "reflex: the robot has stopped; restart drake-franka-driver"};
    case Status::USER_STOPPED:
      return {Phase::kFault, "the user stop is pressed: release it and restart drake-franka-driver"};
    case Status::GUIDING:
      return {Phase::kWaiting, "the robot is guided by hand"};
    case Status::AUTOMATIC_ERROR_RECOVERY:
      return {Phase::kWaiting, "the robot recovers from an error"};
    default:
      return {Phase::kWaiting, "drake-franka-driver is starting, or late"};
  }
}

}  // namespace multireach::drivers
