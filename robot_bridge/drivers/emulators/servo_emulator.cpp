#include "robot_bridge/drivers/emulators/servo_emulator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace multireach::drivers {
namespace {

constexpr double kStepsPerRad = 4096 / (2 * std::numbers::pi);
constexpr double kServo = 50;  // rad/s, assumed
constexpr int64_t kBootMs = 300;
constexpr uint8_t kRangeError = 4, kAlert = 0x80, kOverloadBit = 32;
constexpr int kLimits = 44, kVelocityLimit = 1023;  // of Dynamixel
constexpr uint8_t kFeetechLimits = 9;
constexpr int kFeetechOthers = 140 << 8 | 70;             // largest voltage, 0.1 V, and temperature, degrees Celsius
constexpr int kTorque = 64, kWatchdog = 98, kGoal = 116;  // of Dynamixel
constexpr uint8_t kFeetechTorque = 40, kFeetechGoal = 42;
constexpr double kDynamixelSpeed = 0.229 * 2 * std::numbers::pi / 60;  // rad/s of one unit

}  // namespace

ServoEmulator::ServoEmulator(const Chain& chain, const JointVector& start, ServoOptions options)
    : motors_(static_cast<size_t>(chain.size())), options_(std::move(options)), chain_(chain), joints_(start) {
  if (options_.signs.empty()) options_.signs.assign(motors_.size(), 1);
  if (options_.zero_steps.empty()) options_.zero_steps.assign(motors_.size(), 2048);
}

int ServoEmulator::index_of(int id) const {
  const auto found = std::ranges::find(options_.motor_ids, id);
  return found == options_.motor_ids.end() ? -1 : static_cast<int>(found - options_.motor_ids.begin());
}

int ServoEmulator::steps(int motor) const {
  const auto i = static_cast<size_t>(motor);
  return static_cast<int>(
      std::lround(options_.zero_steps[i] + options_.signs[i] * joints_.position[motor] * kStepsPerRad));
}

double ServoEmulator::velocity(int motor) const {
  return options_.signs[static_cast<size_t>(motor)] * joints_.velocity[motor];
}

void ServoEmulator::collide() {
  Motor& motor = motors_[motors_.size() > 1 ? 1 : 0];
  motor.overload = true;
  motor.torque = false;
  fault_ = "overload of a motor";
}

void ServoEmulator::clear_overload(int motor) {
  motors_[static_cast<size_t>(motor)].overload = false;
  if (std::ranges::none_of(motors_, &Motor::overload)) fault_.clear();
}

void ServoEmulator::restart() {
  for (Motor& motor : motors_) boot(motor);
  fault_.clear();
  answers_.clear();
  answers_from_ms_ = ms_ + kBootMs;
}

void ServoEmulator::tick(const Time&, WireOutbox& out) {
  ++ms_;
  for (; !answers_.empty() && answers_.front().first <= ms_; answers_.pop_front())
    out.push_back({0, std::move(answers_.front().second)});
  JointVector target = joints_.position;
  for (int i = 0; i < target.size(); ++i) {
    const auto k = static_cast<size_t>(i);
    Motor& motor = motors_[k];
    if (motor.watchdog > 0 && ms_ - heard_ms_ > 20 * motor.watchdog) motor.watchdog = -1;
    if (motor.torque && motor.watchdog >= 0)
      target[i] = options_.signs[k] * (motor.goal - options_.zero_steps[k]) / kStepsPerRad;
  }
  joints_.follow(target, kServo, 1e-3);
  joints_.velocity = joints_.velocity.cwiseMax(-chain_.velocity()).cwiseMin(chain_.velocity()).eval();
}

void DynamixelEmulator::write(int motor, int address, int value) {
  Motor& at = motors_[static_cast<size_t>(motor)];
  if (address == kTorque) at.torque = value == 1 && !at.overload;
  if (address == kWatchdog && (value == 0 || at.watchdog >= 0)) at.watchdog = value;
  if (address != kGoal) return;
  if (at.watchdog < 0) {
    answer(dynamixel::encode(
        {static_cast<uint8_t>(options_.motor_ids[static_cast<size_t>(motor)]), dynamixel::kStatus, {kRangeError}}));
    return;
  }
  if (value >= at.lowest && value <= at.highest) at.goal = value;
}

void DynamixelEmulator::receive(size_t, std::span<const uint8_t> bytes, const Time&, WireOutbox&) {
  if (!answers()) return;
  stream_.add(bytes);
  while (const auto packet = stream_.next()) {
    heard_ms_ = ms_;
    const std::vector<uint8_t>& p = packet->parameters;
    if (packet->instruction == dynamixel::kSyncWrite && p.size() >= 4) {
      const int address = dynamixel::get(p, 0, 2), size = dynamixel::get(p, 2, 2);
      if (size != 1 && size != 2 && size != 4) continue;
      const auto block = static_cast<size_t>(size) + 1;
      for (size_t at = 4; at + block <= p.size(); at += block) {
        if (const int motor = index_of(p[at]); motor >= 0) write(motor, address, dynamixel::get(p, at + 1, size));
      }
    } else if (packet->instruction == dynamixel::kSyncRead && p.size() >= 4) {
      for (size_t at = 4; at < p.size(); ++at) {
        const int motor = index_of(p[at]);
        if (motor < 0) continue;
        dynamixel::Packet status{p[at], dynamixel::kStatus, {}};
        status.parameters.push_back(motors_[static_cast<size_t>(motor)].overload ? kAlert : 0);
        const Motor& read = motors_[static_cast<size_t>(motor)];
        if (dynamixel::get(p, 0, 2) == kLimits) {
          for (const int value : {kVelocityLimit, read.highest, read.lowest})
            dynamixel::put(status.parameters, value, 4);
        } else {
          dynamixel::put(status.parameters, std::lround(velocity(motor) / kDynamixelSpeed), 4);
          dynamixel::put(status.parameters, steps(motor), 4);
        }
        answer(dynamixel::encode(status));
      }
    } else if (packet->instruction == dynamixel::kReboot) {
      if (const int motor = index_of(packet->id); motor >= 0) {
        boot(motors_[static_cast<size_t>(motor)]);
        clear_overload(motor);
      }
    }
  }
}

void FeetechEmulator::receive(size_t, std::span<const uint8_t> bytes, const Time&, WireOutbox&) {
  if (!answers()) return;
  stream_.add(bytes);
  while (const auto packet = stream_.next()) {
    const std::vector<uint8_t>& p = packet->parameters;
    if (packet->instruction == feetech::kSyncWrite && p.size() >= 2) {
      const size_t block = size_t{1} + p[1];
      for (size_t at = 2; at + block <= p.size(); at += block) {
        const int motor = index_of(p[at]);
        if (motor < 0) continue;
        Motor& written = motors_[static_cast<size_t>(motor)];
        if (p[0] == kFeetechGoal && p[1] == 2)
          written.goal = std::clamp(feetech::from_sign_magnitude(static_cast<uint16_t>(p[at + 1] | p[at + 2] << 8)),
                                    written.lowest, written.highest);
        if (p[0] == kFeetechTorque && p[1] == 1 && p[at + 1] == 0) clear_overload(motor);
        if (p[0] == kFeetechTorque && p[1] == 1) written.torque = p[at + 1] == 1 && !written.overload;
      }
    } else if (packet->instruction == feetech::kSyncRead && p.size() >= 2) {
      for (size_t at = 2; at < p.size(); ++at) {
        const int motor = index_of(p[at]);
        if (motor < 0) continue;
        feetech::Packet status{p[at], motors_[static_cast<size_t>(motor)].overload ? kOverloadBit : uint8_t{0}, {}};
        const Motor& read = motors_[static_cast<size_t>(motor)];
        const auto speed = static_cast<int>(std::lround(velocity(motor) * kStepsPerRad));
        const auto words = p[0] == kFeetechLimits ? std::vector<int>{read.lowest, read.highest, kFeetechOthers}
                                                  : std::vector<int>{steps(motor), speed};
        for (const int value : words) {
          const uint16_t word = feetech::sign_magnitude(value);
          status.parameters.push_back(static_cast<uint8_t>(word));
          status.parameters.push_back(static_cast<uint8_t>(word >> 8));
        }
        answer(feetech::encode(status));
      }
    }
  }
}

}  // namespace multireach::drivers
