#pragma once

#include <optional>

#include "robot_bridge/drivers/emulators/emulator.hpp"

namespace multireach::drivers {

/// drake-iiwa-driver with an iiwa that runs its application for positions, in steps of 5 ms. It ends, and sends
/// nothing until restart(): after a command that comes before the first status or within 0.25 s of it, one with a wrong
/// number of joints, a collision, or a step that is faster than a joint's largest speed (the robot then ends the FRI
/// session).
class IiwaEmulator : public Emulator {
 public:
  /// `chain` has the manufacturer's speed limits. `start`: joint positions, rad.
  IiwaEmulator(const Chain& chain, const JointVector& start);

  std::vector<Link> links() const override {
    return {{.kind = Link::Kind::kLcm, .receive = "IIWA_COMMAND", .send = "IIWA_STATUS"}};
  }
  void receive(size_t link, std::span<const uint8_t> bytes, const Time& now, WireOutbox& out) override;
  void tick(const Time& now, WireOutbox& out) override;
  void collide() override { end("external torque"); }
  void restart() override;
  const JointVector& position() const override { return joints_.position; }
  const std::string& fault() const override { return fault_; }

 private:
  void end(const std::string& why);
  void step(const Time& now, WireOutbox& out);

  Chain chain_;
  EmulatedJoints joints_;
  std::string fault_;
  std::optional<JointVector> held_;    // joint positions held since commanding became active, or commanded
  std::optional<JointVector> wanted_;  // the newest command
  JointVector from_, to_;              // interpolated over one step
  int64_t ticks_ = 0, statuses_ = 0;
  std::optional<int64_t> first_status_us_;
};

}  // namespace multireach::drivers
