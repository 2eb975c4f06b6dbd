#pragma once

#include "robot_bridge/drivers/dynamixel.hpp"
#include "robot_bridge/drivers/servo_bus.hpp"

namespace multireach::drivers {

/// Dynamixel motors of the X series in position mode: sync write of goals, sync read of speeds and positions, and the
/// motors' own watchdog, which stops them 60 ms after the last packet. reset() reboots the motors that report a
/// hardware error.
class DynamixelDriver : public ServoBus {
 public:
  using ServoBus::ServoBus;
  void receive(size_t link, std::span<const uint8_t> bytes, const Time& now, WireOutbox& out) override;

 protected:
  void append_start(std::vector<uint8_t>& bytes) override;
  void append_goals(const std::vector<int>& steps, std::vector<uint8_t>& bytes) override;
  void append_read(std::vector<uint8_t>& bytes) override;
  void append_read_limits(std::vector<uint8_t>& bytes) override;
  void append_reset(std::vector<uint8_t>& bytes) override;
  void clear_stream() override { stream_.clear(); }
  double velocity_unit() const override;
  int64_t most_late_us() const override;
  int watchdog_units() const;

 private:
  void append_sync_read(int address, int size, std::vector<uint8_t>& bytes) const;
  void append_sync_write(int address, int size, const std::vector<int>& values, std::vector<uint8_t>& bytes) const;

  dynamixel::Stream stream_;
  std::vector<int> alerted_;  // motors with a hardware error
};

}  // namespace multireach::drivers
