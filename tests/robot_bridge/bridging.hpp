#pragma once

#include <gtest/gtest.h>

#include "robot_bridge/bridge.hpp"
#include "tests/test_arms.hpp"

namespace multireach::robot_bridge {

inline constexpr int64_t kPeriod = 50000, kDelay = 5000, kRobot = 11, kController = 12;

/// A bridge for the Hoap2, set-points on a ramp, and a robot that does what it is told.
class Bridging : public ::testing::Test {
 protected:
  Bridging() { start_ << 0.1, -0.5, -0.2, -0.8; }

  /// The k-th set-point of a slow ramp that starts smoothly.
  Setpoint ramp(int64_t k) const {
    const double t = static_cast<double>(k), smooth = t < 10 ? t * t / 20 : t - 5, rate = t < 10 ? t / 10 : 1;
    return {.run = kController,
            .utime = k * kPeriod,
            .sequence = k,
            .theta = start_ + smooth * slope_,
            .velocity = rate * slope_ / 0.05};
  }
  Measurement at(const JointVector& theta, int64_t utime = 0, int64_t run = kRobot) const {
    return {.run = run, .utime = utime, .theta = theta, .velocity = JointVector::Zero(4)};
  }
  SetpointVerdict give(Bridge& bridge, const Setpoint& setpoint) const {
    bool restarted = false;
    return bridge.setpoint(setpoint, restarted);
  }
  /// A tick of a robot that does what it is told and says so.
  Command obeyed_tick(Bridge& bridge) const {
    Command command = bridge.tick();
    EXPECT_TRUE(bridge.measured(at(command.theta, command.utime)));
    return command;
  }
  /// Ten measurements of a robot that was not followed before.
  bool heard_for_long(Bridge& bridge, const Measurement& measurement) const {
    for (int k = 0; k < 9; ++k) EXPECT_FALSE(bridge.measured(measurement));
    return bridge.measured(measurement);
  }
  /// Follows the ramp from its start until set-point `k` is executed.
  Bridge running(int64_t k, const BridgeOptions& options = {}) const {
    Bridge bridge(chain_, options);
    EXPECT_TRUE(bridge.measured(at(start_)));
    for (int64_t i = 0; i <= k; ++i) {
      EXPECT_EQ(give(bridge, ramp(i)), SetpointVerdict::kAccepted);
      for (int ms = 0; ms < 50; ++ms) obeyed_tick(bridge);
    }
    return bridge;
  }

  Chain chain_ = testing::hoap2();
  JointVector start_{4}, slope_ = JointVector::Constant(4, -0.005);
};

}  // namespace multireach::robot_bridge
