#pragma once

#include <optional>

#include "robot_bridge/drivers/emulators/emulator.hpp"
#include "robot_bridge/drivers/franka_limits.hpp"

namespace multireach::drivers {

struct PandaEmulatorOptions {
  FrankaModel model = FrankaModel::kPanda;
  bool limit_rate = true;  ///< libfranka's rate limiter, which drake-franka-driver switches on
};

/// drake-franka-driver in its mode for positions with a Panda or a Research 3: 1 kHz, low-pass filter, rate limiter,
/// and the robot's checks of position, velocity, acceleration and jerk on what comes out. It ends, and sends nothing
/// until restart(), after any error of the robot, a command of another mode, and a collision. Commands whose time is
/// more than 0.1 s off the wall clock are expired: the last position is held.
class PandaEmulator : public Emulator {
 public:
  /// `chain` has the manufacturer's speed limits and seven joints. `start`: joint positions, rad.
  PandaEmulator(const Chain& chain, const JointVector& start, const PandaEmulatorOptions& options = {});

  std::vector<Link> links() const override {
    return {{.kind = Link::Kind::kLcm, .receive = "PANDA_COMMAND", .send = "PANDA_STATUS"}};
  }
  void receive(size_t link, std::span<const uint8_t> bytes, const Time& now, WireOutbox& out) override;
  void tick(const Time& now, WireOutbox& out) override;
  void collide() override { end("cartesian_reflex"); }
  void restart() override;
  const JointVector& position() const override { return joints_.position; }
  const std::string& fault() const override { return fault_; }

 private:
  void end(const std::string& why);
  JointVector fastest(bool upwards) const;
  void control(const Time& now);
  void check(const JointVector& velocity, const JointVector& acceleration, const JointVector& jerk);
  void send_status(const Time& now, WireOutbox& out) const;

  Chain chain_;
  PandaEmulatorOptions options_;
  FrankaLimits limits_;
  EmulatedJoints joints_;
  JointVector desired_, velocity_, acceleration_;  // the robot's set-point, and its derivatives
  std::optional<JointVector> wanted_;              // the newest command
  int64_t wanted_utime_ = 0;
  std::string fault_;
  int64_t ticks_ = 0;
};

}  // namespace multireach::drivers
