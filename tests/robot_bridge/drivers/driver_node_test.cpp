// What every driver has in common: which commands it obeys, when it sends nothing, and the template.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "robot_bridge/drivers/node/driver_node.hpp"
#include "robot_bridge/drivers/template_driver.hpp"
#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"
#include "tests/robot_bridge/drivers/driver_loop.hpp"

namespace multireach::testing {
namespace {

using drivers::DriverStatus;

/// A robot for the template driver: it is where it was commanded to be, and says so every 2 ms.
class EchoRobot {
 public:
  EchoRobot() {
    auto to_robot = std::make_shared<Stream>(), from_robot = std::make_shared<Stream>();
    driver_side = std::make_unique<MemoryTransport>(from_robot, to_robot, now_ms, faults, false);
    robot_side = std::make_unique<MemoryTransport>(to_robot, from_robot, now_ms, faults, false);
    robot_side->open(0);
  }
  void step() {
    std::vector<uint8_t> bytes;
    if (!robot_side->receive(bytes)) robot_side->close();
    if (!robot_side->open(0)) return;
    received += bytes.size();
    if (bytes.size() >= sizeof q) std::memcpy(&q, bytes.data() + bytes.size() - sizeof q, sizeof q);
    const auto* raw = reinterpret_cast<const uint8_t*>(&q);
    if (now_ms % 2 == 0) (void)robot_side->send({raw, sizeof q});
  }

  int64_t now_ms = 0;
  WireFaults faults;
  std::unique_ptr<drivers::Transport> driver_side, robot_side;
  std::array<double, 4> q{0.2, -0.3, -0.2, -0.9};  // the Hoap2 at its start
  size_t received = 0;
};

class TemplateDriverTest : public ::testing::Test {
 protected:
  TemplateDriverTest() {
    drivers::Transports transports;
    transports.push_back(std::move(echo.driver_side));
    node = std::make_unique<drivers::DriverNode>(robot, std::make_unique<drivers::TemplateDriver>(4, "the robot", 5000),
                                                 std::move(transports), drivers::DriverNodeOptions{},
                                                 [this] { return 1000 * echo.now_ms + clock_error_us; });
    node->set_run(77);
  }
  void run(int64_t ms) {
    for (int64_t k = 0; k < ms; ++k, ++echo.now_ms) {
      echo.step();
      node->tick(out);
    }
  }
  joint_command_t command(const JointVector& q, const JointVector& v) {
    joint_command_t message{};
    message.utime = echo.now_ms * 1000;
    message.run = 5;
    message.robot_run = 77;
    message.sequence = sequence++;
    message.num_joints = 4;
    message.joint_name = joint_names(robot.chain);
    message.joint_position = to_field(q);
    message.joint_velocity = to_field(v);
    return message;
  }
  void send(const joint_command_t& message) { node->receive(channel::kJointCommand, *encode(message), out); }
  std::optional<robot_state_t> newest_state() const {
    for (auto message = out.rbegin(); message != out.rend(); ++message) {
      if (message->channel == channel::kRobotState) return decode<robot_state_t>(message->bytes);
    }
    return std::nullopt;
  }

  const RobotConfig robot = robot_named("hoap2");
  EchoRobot echo;
  std::unique_ptr<drivers::DriverNode> node;
  Outbox out;
  int64_t sequence = 0, clock_error_us = 0;
  JointVector start = (JointVector(4) << 0.2, -0.3, -0.2, -0.9).finished();
  JointVector zero = JointVector::Zero(4);
};

TEST_F(TemplateDriverTest, MeasuresAndCommands) {
  run(20);
  ASSERT_TRUE(newest_state());
  EXPECT_EQ(newest_state()->run, 77);
  EXPECT_EQ(newest_state()->command_sequence, -1);
  EXPECT_EQ(newest_state()->joint_position, to_field(start));
  EXPECT_EQ(node->state(), "ready");
  JointVector q = start;
  for (int k = 0; k < 50; ++k) {
    const double t = 1e-3 * k;
    q[0] = start[0] + 10 * t * t;
    send(command(q, 20 * t * JointVector::Unit(4, 0)));
    run(1);
  }
  EXPECT_EQ(node->counters().refused, 0);
  EXPECT_NEAR(newest_state()->joint_position[0], q[0], 5e-3) << "of 24 mrad";
  EXPECT_EQ(node->state(), "ready, following");
}

// A bridge that was started with --speed 2, or --speed 1.05, keeps the limits in its own time only.
TEST_F(TemplateDriverTest, RefusesCommandsThatComeFasterThanRealTime) {
  for (const double speed : {0.5, 1.0, 1.001, 1.05, 2.0}) {
    SCOPED_TRACE(speed);
    run(1000);  // the last motion is over
    const int64_t refused = node->counters().refused, begin_ms = echo.now_ms;
    sequence += 1000;
    double sent = 0;
    const JointVector from = JointVector::Map(echo.q.data(), 4);
    int64_t refused_after_ms = -1;
    for (int64_t ms = 0; ms < 2000; ++ms) {
      for (; sent < speed * static_cast<double>(ms); ++sent) {
        auto message = command(from + 2e-5 * sent * JointVector::Unit(4, 3), 0.02 * JointVector::Unit(4, 3));
        message.utime = begin_ms * 1000 + static_cast<int64_t>(sent) * 1000;
        send(message);
      }
      run(1);
      if (node->counters().refused == refused || refused_after_ms >= 0) continue;
      refused_after_ms = ms;
      EXPECT_NE(node->state().find("faster than real time"), std::string::npos) << node->state();
    }
    if (speed <= 1.001) {
      EXPECT_EQ(node->counters().refused, refused) << node->state();
      continue;
    }
    EXPECT_GT(refused_after_ms, 0);
    EXPECT_LT(static_cast<double>(refused_after_ms) * (speed - 1.002), 25) << "20 ms ahead";
  }
}

// Where it may be a delay of the network, the arm is followed again; a bridge that is faster each time is not.
TEST_F(TemplateDriverTest, ABridgeThatIsFasterThanRealTimeStaysRefusedUntilTheUserAsks) {
  run(20);
  double sent = 0;
  const auto run_fast = [&](int64_t ms) {
    for (const int64_t end = echo.now_ms + ms; echo.now_ms < end;) {
      for (const double until = sent + 1.5; sent + 1 <= until; ++sent) {
        auto message = command(start + 2e-5 * sent * JointVector::Unit(4, 3), 0.02 * JointVector::Unit(4, 3));
        message.utime = 20000 + static_cast<int64_t>(sent) * 1000;
        send(message);
      }
      sent += 0.5;
      run(1);
    }
  };
  run_fast(600);
  EXPECT_NE(node->state().find("ready, refused commands that come faster than real time"), std::string::npos)
      << node->state();
  const auto before = echo.q;
  run_fast(300);
  EXPECT_EQ(echo.q, before) << "it is not followed any more";
  bridge_state_t bridge{};
  bridge.run = 5;
  bridge.robot_run = 77;
  node->receive(channel::kBridgeState, *encode(bridge), out);
  bridge_request_t reset{};
  reset.run = 5;
  reset.kind = bridge_request_t::RESET;
  reset.request = 1;
  node->receive(channel::kBridgeRequest, *encode(reset), out);
  auto message = command(start, zero);
  message.utime = echo.now_ms * 1000;
  const auto refused = node->counters().refused;
  JointVector here = JointVector::Map(echo.q.data(), 4);
  message.joint_position = to_field(here);
  send(message);
  EXPECT_EQ(node->counters().refused, refused) << node->state();
}

// Commands that waited while the driver was stopped belong to a motion of before.
TEST_F(TemplateDriverTest, AfterAStopItFollowsOnlyWhatIsNearAndOfNow) {
  for (const bool far : {false, true}) {
    SCOPED_TRACE(far);
    run(1000);
    const JointVector from = JointVector::Map(echo.q.data(), 4);
    for (int k = 0; k < 100; ++k) {
      send(command(from, zero));
      run(1);
    }
    EXPECT_NE(node->state().find("following"), std::string::npos) << node->state();
    auto waited = command(from, zero);
    node->skip_ticks(200);
    echo.now_ms += 200;
    const auto refused = node->counters().refused;
    send(waited);
    EXPECT_EQ(node->counters().refused, refused + 1);
    EXPECT_NE(node->state().find("waited while the driver was stopped"), std::string::npos) << node->state();
    run(60);
    send(command(from + (far ? 0.4 : 0.001) * JointVector::Unit(4, 3), zero));
    EXPECT_EQ(node->counters().refused, refused + (far ? 2 : 1)) << node->state();
    run(1);
    EXPECT_LT(std::abs(echo.q[3] - from[3]), 0.01) << "no step";
  }
}

// Anyone can read its run in ROBOT_STATE.
TEST_F(TemplateDriverTest, NoMessageEndsIt) {
  run(20);
  bridge_request_t request{};
  request.run = 77;
  request.kind = bridge_request_t::DISABLE;
  node->receive(channel::kBridgeRequest, *encode(request), out);
  run(20);
  EXPECT_FALSE(node->finished());
  EXPECT_TRUE(node->begin_end());
  EXPECT_TRUE(node->finished()) << "at standstill";
}

TEST_F(TemplateDriverTest, ADelayOfTheNetworkIsNotFasterThanRealTime) {
  run(20);
  JointVector q = start;
  std::vector<joint_command_t> held;
  for (int k = 0; k < 400; ++k) {
    q[3] += 1e-4;
    held.push_back(command(q, 0.1 * JointVector::Unit(4, 3)));
    const int delay = (k / 100) * 5;  // 0, 5, 10 and 15 ms, then all at once
    if (delay == 0 || k % delay == 0) {
      for (const auto& message : std::exchange(held, {})) send(message);
    }
    run(1);
  }
  EXPECT_EQ(node->counters().refused, 0) << node->state();
}

TEST_F(TemplateDriverTest, RefusesByName) {
  const auto refused = [&](const joint_command_t& message, const std::string& why, bool following = false) {
    const auto before = node->counters().refused;
    const size_t received = echo.received;
    send(message);
    run(2);
    EXPECT_EQ(node->counters().refused, before + 1) << why;
    EXPECT_EQ(echo.received > received, following) << why;
    EXPECT_NE(node->state().find(why), std::string::npos) << node->state();
  };
  refused(command(start, zero), "while the robot is not ready");
  run(20);
  auto other = command(start, zero);
  other.robot_run = 78;
  refused(other, "for another robot");
  refused(command(start + JointVector::Constant(4, -0.31), zero), "far from the arm");
  auto nan = command(start, zero);
  nan.joint_position[2] = NAN;
  refused(nan, "without a valid position");
  auto missing = command(start, zero);
  missing.joint_name[1] = "nobody";
  refused(missing, "without a valid position");
  JointVector beyond = start;
  beyond[3] = 0.5;  // the elbow's upper limit is 0
  refused(command(beyond, zero), "beyond the joints' limits");
  send(command(start, zero));
  run(2);
  other = command(start, zero);
  other.run = 6;
  refused(other, "of another bridge", true);
}

TEST_F(TemplateDriverTest, RefusesCommandsThatFollowFromRecordedImages) {
  run(20);
  const JointVector here = Eigen::Map<const Eigen::Vector4d>(echo.q.data());
  joint_command_t old = command(here, JointVector::Zero(4));
  old.utime += 86400000000;
  send(old);
  EXPECT_EQ(node->counters().refused, 1);
  EXPECT_NE(node->state().find("--accept-recorded"), std::string::npos) << node->state();
  send(command(here, JointVector::Zero(4)));
  EXPECT_EQ(node->counters().refused, 1);
}

TEST_F(TemplateDriverTest, AStepOfTheWallClockEndsNoMotion) {
  run(20);
  for (const int64_t step : {int64_t{0}, int64_t{3600000000}, int64_t{-7200000000}}) {
    clock_error_us += step;
    for (int k = 0; k < 50; ++k) {
      send(command(start, zero));
      run(1);
    }
    EXPECT_EQ(node->counters().refused, 0) << step << ": " << node->state();
    EXPECT_EQ(node->state(), "ready, following");
  }
  // But a stream whose own time steps, as when recorded images take over, is judged anew.
  auto recorded = command(start, zero);
  recorded.utime += 86400000000;
  send(recorded);
  EXPECT_EQ(node->counters().refused, 1);
  EXPECT_NE(node->state().find("--accept-recorded"), std::string::npos) << node->state();
}

TEST_F(TemplateDriverTest, ABridgeWhoseCommandsAreRefusedOwnsNothing) {
  run(20);
  auto far = command(start + JointVector::Constant(4, -0.31), zero);
  far.run = 6;
  send(far);
  EXPECT_EQ(node->counters().refused, 1);
  send(command(start, zero));
  run(2);
  EXPECT_EQ(node->counters().refused, 1) << node->state();
  EXPECT_NE(node->state().find("ready, following"), std::string::npos) << node->state();
  // Nor does it keep what it had.
  for (int k = 0; k < 200; ++k) {
    auto bad = command(start, zero);
    bad.joint_position[0] = NAN;
    send(bad);
    run(1);
  }
  auto other = command(start, zero);
  other.run = 6;
  const auto refused = node->counters().refused;
  send(other);
  EXPECT_EQ(node->counters().refused, refused) << node->state();
}

TEST_F(TemplateDriverTest, TimesAtTheEndsOfTheirRangeAreRefused) {
  run(20);
  for (const int64_t utime : {INT64_MIN, INT64_MIN + 1, int64_t{-1}, INT64_MAX - 1, INT64_MAX}) {
    for (const bool before : {true, false}) {
      SCOPED_TRACE(utime);
      auto message = command(start, zero);
      message.utime = utime;
      if (before) message.sequence = utime;
      const auto refused = node->counters().refused;
      send(message);
      run(1);
      EXPECT_EQ(node->counters().refused, refused + 1);
    }
  }
  send(command(start, zero));
  run(1);
  EXPECT_NE(node->state().find("ready, following"), std::string::npos) << node->state();
}

/// Counts what it is asked for.
class CountingDriver : public drivers::Driver {
 public:
  std::vector<drivers::Link> links() const override { return {}; }
  void receive(size_t, std::span<const uint8_t>, const drivers::Time&, drivers::WireOutbox&) override {}
  void tick(const drivers::Time&, drivers::WireOutbox&) override {}
  void command(const JointVector& position, const JointVector& velocity, int64_t, const drivers::Time&,
               drivers::WireOutbox&) override {
    EXPECT_TRUE(position.allFinite() && velocity.allFinite());
  }
  void enable(const drivers::Time&, drivers::WireOutbox&) override { ++enabled; }
  void reset(const drivers::Time&, drivers::WireOutbox&) override { ++resets; }
  std::optional<drivers::Reading> take_reading() override {
    return drivers::Reading{JointVector::Zero(4), JointVector::Zero(4), JointVector::Zero(4)};
  }
  DriverStatus status() const override { return {DriverStatus::Phase::kReady, "ready"}; }

  int enabled = 0, resets = 0;
};

class IdleDriver : public ::testing::Test {
 protected:
  IdleDriver() { node.set_run(77); }
  void ask(int8_t kind, int64_t bridge) {
    bridge_request_t request{};
    request.kind = kind;
    request.run = bridge;
    request.request = ++requests;
    node.receive(channel::kBridgeRequest, *encode(request), out);
    node.tick(out);
  }
  /// The bridge of that run answers, as it does to every request.
  void bridge_says(int64_t bridge, int64_t robot_run) {
    bridge_state_t state{};
    state.run = bridge;
    state.robot_run = robot_run;
    node.receive(channel::kBridgeState, *encode(state), out);
  }
  void robot_says(int64_t run) {
    robot_state_t state{};
    state.run = run;
    node.receive(channel::kRobotState, *encode(state), out);
  }
  void wait(int64_t ms) {
    for (int64_t k = 0; k < ms; ++k) node.tick(out);
  }

  const RobotConfig robot = robot_named("hoap2");
  CountingDriver* driver = new CountingDriver;
  drivers::DriverNode node{robot, std::unique_ptr<drivers::Driver>(driver), {}, {}, [] { return int64_t{0}; }};
  Outbox out;
  int64_t requests = 0;
};

TEST_F(IdleDriver, ObeysOnlyRequestsToItsOwnBridge) {
  ask(bridge_request_t::ENABLE, 5);
  EXPECT_EQ(driver->enabled, 0) << "of a bridge that nobody has heard, as in an old log";
  bridge_says(5, 0);  // knows no robot yet
  ask(bridge_request_t::ENABLE, 6);
  EXPECT_EQ(driver->enabled, 0);
  ask(bridge_request_t::ENABLE, 5);
  EXPECT_EQ(driver->enabled, 1);
  ask(bridge_request_t::RESET, 5);
  EXPECT_EQ(driver->resets, 1);
}

TEST_F(IdleDriver, IsNotMeantByTheBridgeOfAnotherRobot) {
  robot_says(78);
  bridge_says(5, 78);
  ask(bridge_request_t::ENABLE, 5);
  EXPECT_EQ(driver->enabled, 0);
  bridge_says(6, 77);
  ask(bridge_request_t::ENABLE, 6);
  EXPECT_EQ(driver->enabled, 1);
  wait(2000);  // the other robot has gone; so has the run that this driver had before its restart
  bridge_says(5, 78);
  ask(bridge_request_t::ENABLE, 5);
  EXPECT_EQ(driver->enabled, 2);
}

TEST_F(IdleDriver, ObeysNobodyBetweenTwoBridges) {
  bridge_says(5, 77);
  bridge_says(6, 77);
  ask(bridge_request_t::ENABLE, 5);
  ask(bridge_request_t::ENABLE, 6);
  EXPECT_EQ(driver->enabled, 0);
  EXPECT_NE(node.state().find("two bridges"), std::string::npos) << node.state();
  wait(2000);
  bridge_says(5, 77);
  ask(bridge_request_t::ENABLE, 5);
  EXPECT_EQ(driver->enabled, 1) << "the other has gone";
}

TEST_F(TemplateDriverTest, DeceleratesWithinTheLimitsWhenCommandsEnd) {
  run(20);
  JointVector q = start;
  const double speed = 1.0;
  for (int k = 0; k < 100; ++k) {
    q[0] += speed * 1e-3;
    send(command(q, speed * JointVector::Unit(4, 0)));
    run(1);
  }
  std::vector<double> position{echo.q[0]};
  for (int k = 0; k < 300; ++k) {
    run(1);
    position.push_back(echo.q[0]);
  }
  // 60 rad/s^2 stop 1 rad/s within 17 ms and the jerk limit's share; from 3 ms after the last command on.
  EXPECT_GT(position.back(), position[1] + 0.005);
  EXPECT_LT(position.back(), position[1] + 0.05);
  EXPECT_EQ(position.back(), position[100]);
  for (size_t k = 3; k < position.size(); ++k) {
    const double acceleration = (position[k] - 2 * position[k - 1] + position[k - 2]) * 1e6;
    EXPECT_LT(std::abs(acceleration), 60 * 1.01) << k;
  }
  EXPECT_EQ(node->state(), "ready");
}

TEST_F(TemplateDriverTest, LeadsSmoothlyToCommandsThatBeginElsewhere) {
  run(20);
  const JointVector q = start + 0.2 * JointVector::Unit(4, 0);
  std::vector<double> position(2, echo.q[0]);
  for (int k = 0; k < 600; ++k) {
    send(command(q, zero));
    run(1);
    position.push_back(echo.q[0]);
  }
  EXPECT_NEAR(position.back(), q[0], 1e-12);
  for (size_t k = 2; k < position.size(); ++k) {
    EXPECT_LT(std::abs(position[k] - position[k - 1]) * 1e3, 0.5 * 6 * 1.001) << "half of the speed limit, at " << k;
    EXPECT_LT(std::abs(position[k] - 2 * position[k - 1] + position[k - 2]) * 1e6, 0.5 * 60 * 1.001) << k;
  }
}

TEST_F(TemplateDriverTest, IsSilentWhileTheRobotIsGone) {
  run(20);
  ASSERT_TRUE(newest_state());
  echo.faults.cut = true;
  run(2);
  out.clear();
  run(200);
  EXPECT_FALSE(newest_state());
  EXPECT_EQ(node->state(), "not connected to the robot");
  echo.faults.cut = false;
  run(20);
  EXPECT_TRUE(newest_state());
}

}  // namespace
}  // namespace multireach::testing
