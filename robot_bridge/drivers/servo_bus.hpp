#pragma once

#include <string>
#include <vector>

#include "robot_bridge/drivers/driver.hpp"

namespace multireach::drivers {

/// What the drivers of servo motors on a serial bus have in common.
struct ServoOptions {
  std::string device = "/dev/ttyUSB0";
  int baud = 1000000;
  std::vector<int> motor_ids{};      ///< one for each joint of the chain
  std::vector<double> signs{};       ///< +1 or -1 for each joint: the motor's direction; empty: all +1
  std::vector<double> zero_steps{};  ///< position of each motor where its joint is 0; empty: all 2048
  int64_t period_us = 8000;          ///< from one cycle on the bus to the next
  JointVector lower{}, upper{};  ///< rad: position limits of each joint; empty: those of the motors are not compared
};

/// The cycle on a bus of servos: the motors' own position limits are read and compared with those of the joints, the
/// torque is switched on, then in each period one packet with all goals and one that
/// asks for all positions. A motor that does not answer for 100 ms (3 periods, where these are longer), or reports an
/// error, stops everything: goals are no longer sent, and the torque stays as it is. The subclass implements the
/// packets.
class ServoBus : public Driver {
 public:
  ServoBus(int joints, const ServoOptions& options);

  std::vector<Link> links() const override {
    return {{.kind = Link::Kind::kSerial, .address = options_.device, .number = options_.baud}};
  }
  void link_changed(size_t link, bool up, const Time& now, WireOutbox& out) override;
  void tick(const Time& now, WireOutbox& out) override;
  void command(const JointVector& position, const JointVector& velocity, int64_t utime, const Time& now,
               WireOutbox& out) override;
  void enable(const Time&, WireOutbox&) override { enabled_ = true; }
  void reset(const Time& now, WireOutbox& out) override;
  std::optional<Reading> take_reading() override { return std::exchange(reading_, std::nullopt); }
  DriverStatus status() const override;

 protected:
  static constexpr double kStepsPerTurn = 4096;

  struct Motor {
    int id = 0;
    bool answered = false;
    int position = 0, velocity = 0;  // steps; the protocol's own unit
    bool limited = false;            // its own position limits are known
    int lowest = 0, highest = 0;     // steps
  };

  /// Packets, each as a whole: to prepare the motors and switch their torque on; the goals; what asks for all
  /// positions; to leave a fault.
  virtual void append_start(std::vector<uint8_t>& bytes) = 0;
  virtual void append_goals(const std::vector<int>& steps, std::vector<uint8_t>& bytes) = 0;
  virtual void append_read(std::vector<uint8_t>& bytes) = 0;
  /// What asks for the position limits in all motors' EEPROM.
  virtual void append_read_limits(std::vector<uint8_t>& bytes) = 0;
  virtual void append_reset(std::vector<uint8_t>& bytes) = 0;
  virtual void clear_stream() = 0;
  /// rad/s of one unit of velocity.
  virtual double velocity_unit() const = 0;
  /// From one packet to the next: later, the motors may have stopped by themselves.
  virtual int64_t most_late_us() const { return INT64_MAX; }

  /// For the subclass's receive(): what motor `id` answered; `fault`: "" or what is wrong with it.
  void answered(int id, int position, int velocity, const std::string& fault, const Time& now);
  /// The same, for its position limits, steps.
  void answered_limits(int id, int lowest, int highest);
  const std::vector<Motor>& motors() const { return motors_; }
  int64_t period_us() const { return options_.period_us; }

 private:
  bool complete() const;
  std::string unanswered() const;
  std::string wrong_limits() const;
  int steps_of(size_t joint, double position) const;

  ServoOptions options_;
  RateDivider divider_;
  std::vector<Motor> motors_;
  std::vector<int> goal_;
  bool connected_ = false, enabled_ = false, measured_ = false, commanded_ = false;
  int64_t started_us_ = INT64_MIN / 2, asked_us_ = INT64_MIN / 2;
  bool started_ = false, ready_ = false;
  int64_t complete_us_ = 0, deaf_until_us_ = INT64_MIN / 2;
  std::string fault_, missing_;
  std::optional<Reading> reading_;
};

}  // namespace multireach::drivers
