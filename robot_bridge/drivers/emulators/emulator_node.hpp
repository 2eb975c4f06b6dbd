#pragma once

#include <functional>
#include <memory>

#include "robot_bridge/drivers/emulators/emulator.hpp"
#include "robot_bridge/drivers/node/driver_config.hpp"
#include "robot_bridge/drivers/node/wire_port.hpp"
#include "runtime/node.hpp"

namespace multireach::drivers {

/// An emulator with its transports. An external force on the robot (PERTURBATION) of 20 N or more is a collision.
class EmulatorNode : public Node {
 public:
  EmulatorNode(std::unique_ptr<Emulator> emulator, Transports transports, std::function<int64_t()> wall_clock)
      : emulator_(std::move(emulator)), port_(*emulator_, std::move(transports)), wall_clock_(std::move(wall_clock)) {}

  std::string name() const override { return "robot_emulator"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> next_tick() const override { return utime_; }
  int64_t tick_period_us() const override { return kTickUs; }
  void tick(Outbox& out) override;
  LateTicks late_ticks() const override { return LateTicks::kPause; }
  std::string state() const override {
    return emulator_->fault().empty() ? "running" : "stopped: " + emulator_->fault();
  }
  Emulator& emulator() { return *emulator_; }

  static constexpr int64_t kTickUs = 1000;

 private:
  Time now() const { return {utime_, wall_clock_()}; }

  std::unique_ptr<Emulator> emulator_;
  WirePort port_;
  std::function<int64_t()> wall_clock_;
  int64_t utime_ = 0;
  std::string reported_;
};

/// The emulator of the robot that `config` names, at the start configuration of `robot`. Throws InputError for a driver
/// without an emulator.
std::unique_ptr<Emulator> make_emulator(const RobotConfig& robot, const DriverConfig& config);

}  // namespace multireach::drivers
