#pragma once

#include "robot_bridge/drivers/driver.hpp"
#include "robot_bridge/drivers/status_filter.hpp"

namespace multireach::drivers {

/// Franka Panda or FR3 through drake-franka-driver in its mode for positions: PANDA_STATUS in, PANDA_COMMAND out, each
/// command of the 1 kHz stream. That driver holds the last position once a command is older than 0.1 s by its wall
/// clock, whose time is in each status: commands carry that time, so the clock of this computer does not matter. It
/// ends after any error of the robot.
class PandaDriver : public Driver {
 public:
  explicit PandaDriver(int joints) : joints_(joints), statuses_("PANDA_STATUS", joints) {}

  std::vector<Link> links() const override {
    return {{.kind = Link::Kind::kLcm, .receive = "PANDA_STATUS", .send = "PANDA_COMMAND"}};
  }
  void receive(size_t link, std::span<const uint8_t> bytes, const Time& now, WireOutbox& out) override;
  void tick(const Time& now, WireOutbox& out) override;
  void command(const JointVector& position, const JointVector& velocity, int64_t utime, const Time& now,
               WireOutbox& out) override;
  std::optional<Reading> take_reading() override { return std::exchange(reading_, std::nullopt); }
  DriverStatus status() const override;
  RefusedMessages refused() const override { return {statuses_.refused(), statuses_.text()}; }

 private:
  int joints_;
  StatusFilter statuses_;
  std::optional<int64_t> first_status_us_, heard_us_;
  int64_t robot_clock_us_ = 0;  // of the wall clock of drake-franka-driver's computer, at heard_us_
  int8_t robot_mode_ = 0;
  bool ready_ = false, was_ready_ = false;
  std::optional<Reading> reading_;
};

}  // namespace multireach::drivers
