// The speed of a stream as a recorder sees it: a joint moves at its limit, or too fast, and the recorder or the sender
// is late. A position each millisecond; the robot's clock is known to the last state, one each 4 ms.
#include "tools/log/speed_window.hpp"

#include <gtest/gtest.h>

#include "runtime/robot_config.hpp"

namespace multireach {
namespace {

class Speed : public testing::Test {
 protected:
  /// One millisecond of motion at `share` of the first joint's limit; it arrives at `arrival`, in milliseconds.
  void step(double share, int64_t arrival, int64_t robot) {
    position_[0] += share * chain_.velocity()[0] * 1e-3;
    window_.add(chain_, kBegin + 1000 * arrival, knows_robot_ ? kBegin + robot / 4 * 4000 : 0, position_);
  }
  void on_time(double share, int64_t from, int64_t to) {
    for (int64_t k = from; k < to; ++k) step(share, k, k);
  }

  static constexpr int64_t kBegin = 1'700'000'000'000'000;
  const Chain chain_ = RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml").chain;
  JointVector position_ = JointVector::Zero(chain_.size());
  SpeedWindow window_;
  bool knows_robot_ = true;
};

TEST_F(Speed, OnTimeIsTheShareOfTheLimit) {
  on_time(1, 0, 200);
  EXPECT_NEAR(window_.largest(), 1, 1e-9);
}

TEST_F(Speed, WhatALateRecorderStampsAtOnceIsNotFast) {
  on_time(1, 0, 100);
  for (int64_t k = 100; k < 130; ++k) step(1, 130, k);
  on_time(1, 130, 200);
  EXPECT_LE(window_.largest(), 24.0 / 20 + 1e-9) << "off by up to a period of the robot's state";
}

TEST_F(Speed, WhatASenderSendsAtOnceIsFast) {
  on_time(1, 0, 100);
  for (int64_t k = 100; k < 130; ++k) step(1, 130, 130);
  on_time(1, 130, 200);
  EXPECT_GE(window_.largest(), 2);
}

TEST_F(Speed, TooFastIsSeenWithALateRecorder) {
  on_time(2, 0, 100);
  for (int64_t k = 100; k < 130; ++k) step(2, 130, k);
  on_time(2, 130, 200);
  EXPECT_GE(window_.largest(), 2 - 1e-9);
}

TEST_F(Speed, WithoutARobotOnlyArrivalsCount) {
  knows_robot_ = false;
  on_time(1, 0, 100);
  for (int64_t k = 100; k < 130; ++k) step(1, 130, k);
  on_time(1, 130, 200);
  EXPECT_GE(window_.largest(), 2);
}

}  // namespace
}  // namespace multireach
