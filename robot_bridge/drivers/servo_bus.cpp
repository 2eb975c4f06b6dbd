#include "robot_bridge/drivers/servo_bus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace multireach::drivers {
namespace {

constexpr int64_t kSettle = 50000;    // us from switching the torque on to the first goals
constexpr int64_t kSilence = 100000;  // us without the answers of all motors

}  // namespace

ServoBus::ServoBus(int joints, const ServoOptions& options)
    : options_(options), divider_(options.period_us), goal_(static_cast<size_t>(joints), 0) {
  const auto n = static_cast<size_t>(joints);
  if (options_.signs.empty()) options_.signs.assign(n, 1);
  if (options_.zero_steps.empty()) options_.zero_steps.assign(n, kStepsPerTurn / 2);
  for (const int id : options.motor_ids) motors_.push_back({.id = id});
}

void ServoBus::link_changed(size_t, bool up, const Time&, WireOutbox&) {
  connected_ = up;
  started_ = measured_ = false;
  for (Motor& motor : motors_) motor.limited = false;
  clear_stream();
}

int ServoBus::steps_of(size_t joint, double position) const {
  const double turns = options_.signs[joint] * position / (2 * std::numbers::pi);
  return static_cast<int>(std::lround(options_.zero_steps[joint] + turns * kStepsPerTurn));
}

void ServoBus::command(const JointVector& position, const JointVector&, int64_t utime, const Time&, WireOutbox&) {
  if (!divider_.is_due(utime)) return;
  for (size_t i = 0; i < goal_.size(); ++i) goal_[i] = steps_of(i, position[static_cast<Eigen::Index>(i)]);
  commanded_ = true;  // sent with the next cycle
}

void ServoBus::reset(const Time& now, WireOutbox& out) {
  if (fault_.empty() || !connected_) return;
  std::vector<uint8_t> bytes;
  append_reset(bytes);
  out.push_back({0, std::move(bytes)});
  fault_.clear();
  started_ = measured_ = false;
  for (Motor& motor : motors_) motor.limited = false;  // the user may have changed them
  started_us_ = INT64_MIN / 2;
  deaf_until_us_ = now.us + 2 * options_.period_us;  // answers that are on their way tell of the time before
}

bool ServoBus::complete() const {
  return std::ranges::all_of(motors_, [](const Motor& motor) { return motor.answered; });
}

void ServoBus::answered(int id, int position, int velocity, const std::string& fault, const Time& now) {
  const auto motor = std::ranges::find(motors_, id, &Motor::id);
  if (motor == motors_.end() || now.us < deaf_until_us_) return;
  if (!fault.empty() && fault_.empty()) fault_ = "motor " + std::to_string(id) + ": " + fault;
  const bool was_complete = complete();
  motor->answered = true;
  motor->position = position;
  motor->velocity = velocity;
  if (was_complete || !complete()) return;
  complete_us_ = now.us;
  Reading reading;
  const auto n = static_cast<Eigen::Index>(motors_.size());
  reading.position = reading.velocity = reading.effort = JointVector::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<size_t>(i);
    reading.position[i] =
        options_.signs[k] * (motors_[k].position - options_.zero_steps[k]) / kStepsPerTurn * 2 * std::numbers::pi;
    // A motor at rest reports 0 or one unit, and one of a Dynamixel is more than the bridge's standstill.
    const int units = std::abs(motors_[k].velocity) > 1 ? motors_[k].velocity : 0;
    reading.velocity[i] = options_.signs[k] * units * velocity_unit();
  }
  reading_ = std::move(reading);
  measured_ = true;
}

void ServoBus::answered_limits(int id, int lowest, int highest) {
  const auto motor = std::ranges::find(motors_, id, &Motor::id);
  if (motor == motors_.end()) return;
  motor->limited = true;
  motor->lowest = lowest;
  motor->highest = highest;
}

/// The motors that owe an answer, as text.
std::string ServoBus::unanswered() const {
  std::string ids;
  for (const Motor& motor : motors_) {
    if (!motor.answered) ids += (ids.empty() ? "motor " : ", motor ") + std::to_string(motor.id);
  }
  return ids;
}

/// What is wrong before the torque may be switched on; "" for nothing. A motor ignores or clamps goals beyond its own
/// limits: it would stay behind, or leap to where it may be.
std::string ServoBus::wrong_limits() const {
  for (size_t i = 0; i < motors_.size() && options_.lower.size() > 0; ++i) {
    const auto joint = static_cast<Eigen::Index>(i);
    const Motor& motor = motors_[i];
    const auto [low, high] = std::minmax({steps_of(i, options_.lower[joint]), steps_of(i, options_.upper[joint])});
    if (low < motor.lowest || high > motor.highest) {
      return fmt::format(
          "motor {}: its own position limits (EEPROM) are {} to {} steps, those of the joint {} to {}: narrow the "
          "limits in the URDF, widen the motor's, or correct motor_zeros and motor_signs",
          motor.id, motor.lowest, motor.highest, low, high);
    }
    if (motor.position < motor.lowest || motor.position > motor.highest) {
      return fmt::format("motor {} is at {} steps, outside its own position limits of {} to {}: move it there by hand",
                         motor.id, motor.position, motor.lowest, motor.highest);
    }
  }
  return "";
}

void ServoBus::tick(const Time& now, WireOutbox& out) {
  if (!connected_ || now.us - asked_us_ < options_.period_us) return;
  // Motors that were not asked owe no answer. Their watchdog is fed by what is sent to them.
  const int64_t late = now.us - asked_us_;
  if (started_ && fault_.empty() && late > most_late_us())
    fault_ = fmt::format("the driver was late by {} ms: the motors' watchdog may have stopped them", late / 1000);
  if (late > options_.period_us + kSilence / 2) complete_us_ = now.us;
  const int64_t silence = std::max(kSilence, 3 * options_.period_us);
  if (measured_ && fault_.empty() && now.us - complete_us_ > silence) fault_ = unanswered() + " does not answer";
  missing_ = unanswered();
  asked_us_ = now.us;
  clear_stream();
  for (Motor& motor : motors_) motor.answered = false;
  std::vector<uint8_t> bytes;
  const bool limited = std::ranges::all_of(motors_, &Motor::limited);
  if (measured_ && limited && !started_ && fault_.empty()) fault_ = wrong_limits();
  const bool may_move = enabled_ && measured_ && limited && fault_.empty();
  if (may_move && !started_) {
    append_start(bytes);
    started_ = true;
    started_us_ = now.us;
    commanded_ = false;
  } else if (may_move && std::exchange(commanded_, false)) {
    append_goals(goal_, bytes);
  }
  // One question in each cycle: the answers to two would collide with the next cycle on a slow bus.
  if (limited || !measured_) {
    append_read(bytes);
  } else {
    append_read_limits(bytes);
  }
  out.push_back({0, std::move(bytes)});
  ready_ = may_move && started_ && now.us - started_us_ > kSettle;
}

DriverStatus ServoBus::status() const {
  using Phase = DriverStatus::Phase;
  if (!connected_) return {Phase::kWaiting, "cannot open " + options_.device + " as a serial port"};
  if (!fault_.empty()) return {Phase::kFault, fault_ + "; then multireach-robot reset"};
  if (!measured_) return {Phase::kWaiting, "waiting for an answer of " + (missing_.empty() ? "all motors" : missing_)};
  if (!std::ranges::all_of(motors_, &Motor::limited))
    return {Phase::kWaiting, "waiting for the position limits of all motors"};
  if (!enabled_) return {Phase::kWaiting, "waiting for multireach-robot enable"};
  if (!ready_) return {Phase::kWaiting, "the torque is switched on"};
  return {Phase::kReady, "ready"};
}

}  // namespace multireach::drivers
