#pragma once

#include <deque>

#include "robot_bridge/drivers/dynamixel.hpp"
#include "robot_bridge/drivers/emulators/emulator.hpp"
#include "robot_bridge/drivers/feetech.hpp"
#include "robot_bridge/drivers/servo_bus.hpp"

namespace multireach::drivers {

/// Motors on a serial bus. They begin without torque, answer 2 ms after they are asked, and measure in whole steps. A
/// collision is an overload of the second motor, which gives up its torque; restart() switches the supply off and on:
/// for 300 ms no motor answers.
class ServoEmulator : public Emulator {
 public:
  /// `chain` has the manufacturer's speed limits. `start`: joint positions, rad. `options` must have the ids.
  ServoEmulator(const Chain& chain, const JointVector& start, ServoOptions options);

  std::vector<Link> links() const override {
    return {{.kind = Link::Kind::kSerial, .address = options_.device, .number = options_.baud}};
  }
  void tick(const Time& now, WireOutbox& out) override;
  void collide() override;
  void restart() override;
  const JointVector& position() const override { return joints_.position; }
  const std::string& fault() const override { return fault_; }
  /// Writes a motor's position limits, steps, as a manufacturer's tool does.
  void set_limits(int motor, int lowest, int highest) {
    motors_[static_cast<size_t>(motor)].lowest = lowest;
    motors_[static_cast<size_t>(motor)].highest = highest;
  }

 protected:
  struct Motor {
    int lowest = 0, highest = 4095;  // position limits in its EEPROM, steps
    bool torque = false, overload = false;
    int goal = 0;
    int watchdog = 0;  // of Dynamixel: units of 20 ms; -1: expired
  };

  /// Switches a motor off and on: its EEPROM keeps its limits.
  static void boot(Motor& motor) { motor = {.lowest = motor.lowest, .highest = motor.highest}; }
  /// Index of the motor with this id, or -1.
  int index_of(int id) const;
  int steps(int motor) const;        ///< measured position
  double velocity(int motor) const;  ///< rad/s of the motor
  void answer(std::vector<uint8_t> bytes) { answers_.emplace_back(ms_ + 2, std::move(bytes)); }
  bool answers() const { return ms_ >= answers_from_ms_; }
  void clear_overload(int motor);

  std::vector<Motor> motors_;
  ServoOptions options_;
  int64_t ms_ = 0, heard_ms_ = 0;
  std::string fault_;

 private:
  Chain chain_;
  EmulatedJoints joints_;
  std::deque<std::pair<int64_t, std::vector<uint8_t>>> answers_;
  int64_t answers_from_ms_ = 0;
};

/// Dynamixel X series: watchdog, hardware error, reboot. Goals beyond a motor's limits are ignored.
class DynamixelEmulator : public ServoEmulator {
 public:
  using ServoEmulator::ServoEmulator;
  void receive(size_t link, std::span<const uint8_t> bytes, const Time& now, WireOutbox& out) override;

 private:
  void write(int motor, int address, int value);
  dynamixel::Stream stream_;
};

/// Feetech STS3215: no watchdog; an overload ends when the torque is switched off. Goals beyond a motor's limits are
/// clamped.
class FeetechEmulator : public ServoEmulator {
 public:
  using ServoEmulator::ServoEmulator;
  void receive(size_t link, std::span<const uint8_t> bytes, const Time& now, WireOutbox& out) override;

 private:
  feetech::Stream stream_;
};

}  // namespace multireach::drivers
