#pragma once

#include "robot_bridge/drivers/feetech.hpp"
#include "robot_bridge/drivers/servo_bus.hpp"

namespace multireach::drivers {

/// Feetech motors of the STS series, as the STS3215 of the SO-101: sync write of goals, sync read of positions and
/// speeds. The motors have no watchdog: they hold the last goal. reset() switches the torque off and on again.
class FeetechDriver : public ServoBus {
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

 private:
  void append_sync_write(uint8_t address, uint8_t value, std::vector<uint8_t>& bytes) const;
  void append_sync_read(uint8_t address, uint8_t size, std::vector<uint8_t>& bytes) const;

  feetech::Stream stream_;
};

}  // namespace multireach::drivers
