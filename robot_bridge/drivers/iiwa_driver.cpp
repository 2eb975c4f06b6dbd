#include "robot_bridge/drivers/iiwa_driver.hpp"

#include <drake/lcmt_iiwa_command.hpp>
#include <drake/lcmt_iiwa_status.hpp>

#include "runtime/message.hpp"

namespace multireach::drivers {
namespace {

constexpr int64_t kStartGuard = 400000;  // us: 0.25 s of drake-iiwa-driver (--start_command_guard), and a margin
constexpr int64_t kPause = 30000;        // us, 6 statuses: commands must never meet a driver that is just starting
constexpr int64_t kSilence = 100000;     // us, 20 statuses: it has ended

JointVector vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace

void IiwaDriver::receive(size_t, std::span<const uint8_t> bytes, const Time& now, WireOutbox&) {
  const auto status = decode<drake::lcmt_iiwa_status>(bytes);
  if (!status) return;
  Reading reading{vector_of(status->joint_position_measured), vector_of(status->joint_velocity_estimated),
                  -vector_of(status->joint_torque_measured)};
  if (!statuses_.accepts(status->utime, reading.position, reading.velocity, now.us)) return;
  if (!first_status_us_) first_status_us_ = now.us;
  heard_us_ = now.us;
  warm_ = status->utime >= 0;
  reading_ = std::move(reading);
}

void IiwaDriver::tick(const Time& now, WireOutbox&) {
  if (first_status_us_ && now.us - heard_us_ > kSilence) {
    first_status_us_.reset();
    statuses_.forget();
  }
  ready_ = first_status_us_ && warm_ && now.us - *first_status_us_ > kStartGuard && now.us - heard_us_ < kPause;
  was_ready_ |= ready_;
}

void IiwaDriver::command(const JointVector& position, const JointVector&, int64_t utime, const Time& now,
                         WireOutbox& out) {
  if (!ready_ || !divider_.is_due(utime)) return;
  drake::lcmt_iiwa_command command{};
  command.utime = now.wall_us;
  command.num_joints = joints_;
  command.joint_position.assign(position.begin(), position.end());
  if (auto bytes = encode(command)) out.push_back({0, std::move(*bytes)});
}

DriverStatus IiwaDriver::status() const {
  using Phase = DriverStatus::Phase;
  if (statuses_.only_others() && !was_ready_)
    return {Phase::kWaiting, "IIWA_STATUS has another number of joints than robot.yaml"};
  if (ready_) return {Phase::kReady, "ready"};
  if (first_status_us_) return {Phase::kWaiting, "drake-iiwa-driver is starting, or late"};
  if (was_ready_)
    return {Phase::kFault, "IIWA_STATUS has ended: restart drake-iiwa-driver and its pendant application"};
  return {Phase::kWaiting, "waiting for IIWA_STATUS of drake-iiwa-driver"};
}

}  // namespace multireach::drivers
