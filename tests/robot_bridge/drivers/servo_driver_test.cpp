// The buses of servos: published bytes, stuffing, corrupt streams, and what the motors do.
#include <gtest/gtest.h>

#include <numbers>

#include "robot_bridge/drivers/dynamixel_driver.hpp"
#include "robot_bridge/drivers/emulators/servo_emulator.hpp"
#include "robot_bridge/drivers/feetech_driver.hpp"
#include "tests/robot_bridge/drivers/driver_loop.hpp"

namespace multireach::testing {
namespace {

namespace dynamixel = drivers::dynamixel;
namespace feetech = drivers::feetech;
using Bytes = std::vector<uint8_t>;

// The ping of motor 1 in the manufacturer's manual.
TEST(Dynamixel, WritesThePublishedPing) {
  EXPECT_EQ(dynamixel::encode({1, dynamixel::kPing, {}}),
            (Bytes{0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x01, 0x19, 0x4E}));
}

TEST(Dynamixel, RandomPacketsSurviveStuffingAndGarbage) {
  const CounterRandom random(3);
  uint64_t counter = 0;
  const auto number = [&](double end) { return static_cast<uint8_t>(random.uniform(counter++, 0, end)); };
  for (int k = 0; k < 2000; ++k) {
    SCOPED_TRACE("seed 3, packet " + std::to_string(k));
    dynamixel::Packet packet{number(250), dynamixel::kWrite, Bytes(number(40))};
    // Many headers inside, which must be stuffed.
    for (uint8_t& byte : packet.parameters) byte = number(3) == 0 ? 0xFD : number(2) == 0 ? 0xFF : number(256);
    const Bytes encoded = dynamixel::encode(packet);
    dynamixel::Stream stream;
    stream.add(Bytes{0xFF, 0xFF, 0x00, number(256)});
    for (const uint8_t byte : encoded) stream.add(std::span(&byte, 1));
    const auto decoded = stream.next();
    ASSERT_TRUE(decoded);
    EXPECT_EQ(decoded->id, packet.id);
    EXPECT_EQ(decoded->parameters, packet.parameters);
    Bytes corrupt = encoded;
    corrupt[4 + number(static_cast<double>(corrupt.size() - 4))] ^= 0x21;
    stream.add(corrupt);
    EXPECT_FALSE(stream.next());
  }
}

// Read of the position of motor 1: FF FF 01 04 02 38 02, and the complement of the sum.
TEST(Feetech, WritesTheChecksum) {
  EXPECT_EQ(feetech::encode({1, feetech::kRead, {56, 2}}), (Bytes{0xFF, 0xFF, 0x01, 0x04, 0x02, 0x38, 0x02, 0xBE}));
  for (const int value : {0, 1, -1, 4095, -2048, 32767}) {
    EXPECT_EQ(feetech::from_sign_magnitude(feetech::sign_magnitude(value)), value);
  }
  EXPECT_EQ(feetech::sign_magnitude(-5), 0x8005);
}

TEST(Feetech, FindsPacketsInGarbage) {
  feetech::Stream stream;
  const Bytes packet = feetech::encode({3, 0, {1, 2, 3, 4}});
  stream.add(Bytes{0xFF, 0x00, 0xFF, 0xFF});
  stream.add(packet);
  Bytes corrupt = packet;
  corrupt[6] ^= 4;
  stream.add(corrupt);
  stream.add(packet);
  int found = 0;
  while (const auto decoded = stream.next()) {
    EXPECT_EQ(decoded->parameters, (Bytes{1, 2, 3, 4}));
    ++found;
  }
  EXPECT_EQ(found, 2);
  EXPECT_GE(stream.corrupt(), 1);
}

RobotConfig with_dynamixel() {
  return RobotConfig::load(MULTIREACH_SOURCE_DIR "/tests/data/so101_dynamixel/robot.yaml");
}

TEST(Dynamixel, TheWatchdogStopsTheMotorsWhenTheDriverIsGone) {
  DriverLoop loop(with_dynamixel());
  loop.run(3000);
  ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.driver().state();
  loop.run(900);
  loop.faults.cut = true;
  loop.run(300);
  const JointVector there = loop.emulator().position();
  loop.run(500);
  EXPECT_LT((loop.emulator().position() - there).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_NE(loop.driver().state().find("fault"), std::string::npos) << loop.driver().state();
}

TEST(ServoBus, AnOverloadIsNamedAndResetCuresIt) {
  // At every phase of the cycle on the bus: answers from before the reset may be on their way.
  for (int k = 0; k < 20; ++k) {
    SCOPED_TRACE(k);
    DriverLoop loop(k % 2 ? with_dynamixel() : robot_named("so101"));
    loop.run(3000 + k / 2);
    ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.driver().state();
    loop.emulator().collide();
    loop.run(1500);
    EXPECT_NE(loop.driver().state().find("fault: motor 2"), std::string::npos) << loop.driver().state();
    EXPECT_EQ(loop.bridge_state.state, bridge_state_t::FAULT);
    EXPECT_TRUE(loop.ask(bridge_request_t::RESET));
    loop.run(1000);
    EXPECT_EQ(loop.emulator().fault(), "");
    EXPECT_NE(loop.driver().state().find("ready"), std::string::npos) << loop.driver().state();
    loop.restart_controller();
    loop.run(1000);
    EXPECT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.bridge().state();
  }
}

// What a motor may do by its EEPROM is read before its torque is switched on: beyond it, a Dynamixel ignores goals, and
// would go to the goal of before; a Feetech clamps them.
TEST(ServoBus, AMotorWithNarrowerLimitsThanItsJointIsAFault) {
  for (const bool is_dynamixel : {true, false}) {
    SCOPED_TRACE(is_dynamixel);
    DriverLoop loop(is_dynamixel ? with_dynamixel() : robot_named("so101"));
    auto& emulator = dynamic_cast<drivers::ServoEmulator&>(loop.emulator());
    emulator.set_limits(3, 1500, 2600);
    const JointVector start = emulator.position();
    loop.run(3000);
    EXPECT_NE(loop.driver().state().find("fault: motor 4: its own position limits (EEPROM) are 1500 to 2600"),
              std::string::npos)
        << loop.driver().state();
    EXPECT_NE(loop.bridge_state.state, bridge_state_t::RUNNING);
    EXPECT_LT((emulator.position() - start).cwiseAbs().maxCoeff(), 1e-6) << "nothing has moved";
    emulator.set_limits(3, 0, 4095);
    loop.ask(bridge_request_t::RESET);
    loop.run(2000);
    EXPECT_NE(loop.driver().state().find("ready"), std::string::npos) << loop.driver().state();
    EXPECT_LT(loop.fastest_share, 1.1);
  }
}

TEST(ServoBus, AMotorOutsideItsOwnLimitsDoesNotLeap) {
  for (const bool is_dynamixel : {true, false}) {
    SCOPED_TRACE(is_dynamixel);
    const RobotConfig robot = is_dynamixel ? with_dynamixel() : robot_named("so101");
    auto config = drivers::driver_config_from(robot, "");
    drivers::ServoOptions options = config.servo;
    const JointVector start = JointVector::Constant(5, 0.5);
    options.lower = JointVector::Constant(5, -0.1);
    options.upper = JointVector::Constant(5, 0.1);
    std::unique_ptr<drivers::ServoEmulator> emulator;
    std::unique_ptr<drivers::Driver> driver;
    if (is_dynamixel) {
      emulator = std::make_unique<drivers::DynamixelEmulator>(robot.chain, start, options);
      driver = std::make_unique<drivers::DynamixelDriver>(5, options);
    } else {
      emulator = std::make_unique<drivers::FeetechEmulator>(robot.chain, start, options);
      driver = std::make_unique<drivers::FeetechDriver>(5, options);
    }
    emulator->set_limits(1, 1900, 2200);  // it is at 2374
    drivers::WireOutbox to_robot, to_driver;
    driver->enable({0, 0}, to_robot);
    driver->link_changed(0, true, {0, 0}, to_robot);
    for (int64_t us = 1000; us < 1000000; us += 1000) {
      for (const auto& message : std::exchange(to_robot, {})) emulator->receive(0, message.bytes, {us, us}, to_driver);
      for (const auto& message : std::exchange(to_driver, {})) driver->receive(0, message.bytes, {us, us}, to_robot);
      driver->tick({us, us}, to_robot);
      emulator->tick({us, us}, to_driver);
    }
    EXPECT_EQ(driver->status().phase, drivers::DriverStatus::Phase::kFault);
    EXPECT_NE(driver->status().text.find("motor 2 is at 2374 steps, outside its own position limits of 1900 to 2200"),
              std::string::npos)
        << driver->status().text;
    EXPECT_EQ(emulator->position(), start);
  }
}

// A driver that is not scheduled for 70 ms: by the manual, a watchdog of 3 units has then stopped the motors, and they
// refuse all goals until it is cleared, without an answer to a sync write.
TEST(Dynamixel, AWatchdogThatExpiredIsAFaultAndResetClearsIt) {
  const RobotConfig robot = with_dynamixel();
  const auto options = drivers::driver_config_from(robot, "").servo;
  drivers::DynamixelEmulator emulator(robot.chain, JointVector::Zero(5), options);
  drivers::DynamixelDriver driver(5, options);
  drivers::WireOutbox to_robot, to_driver;
  int64_t us = 0;
  const auto run = [&](int ms, double goal, bool scheduled = true) {
    for (int k = 0; k < ms; ++k) {
      us += 1000;
      for (const auto& message : std::exchange(to_robot, {})) emulator.receive(0, message.bytes, {us, us}, to_driver);
      if (scheduled) {
        for (const auto& message : std::exchange(to_driver, {})) driver.receive(0, message.bytes, {us, us}, to_robot);
        if (driver.status().phase == drivers::DriverStatus::Phase::kReady)
          driver.command(JointVector::Constant(5, goal), JointVector::Zero(5), us, {us, us}, to_robot);
        driver.tick({us, us}, to_robot);
      }
      emulator.tick({us, us}, to_driver);
    }
  };
  driver.enable({0, 0}, to_robot);
  driver.link_changed(0, true, {0, 0}, to_robot);
  run(500, 0.01);
  ASSERT_EQ(driver.status().text, "ready");
  EXPECT_NEAR(emulator.position()[0], 0.01, 1e-3);
  run(70, 0.01, false);
  run(20, 0.02);
  EXPECT_NE(driver.status().text.find("late by 7"), std::string::npos) << driver.status().text;
  EXPECT_NE(driver.status().text.find("watchdog may have stopped them; then multireach-robot reset"), std::string::npos)
      << driver.status().text;
  driver.reset({us, us}, to_robot);
  run(500, 0.02);
  ASSERT_EQ(driver.status().text, "ready");
  EXPECT_NEAR(emulator.position()[0], 0.02, 1e-3);
}

// A slow bus, with the longest period that robot.yaml may name, must not let the motors' watchdog expire.
TEST(ServoBus, TheLongestPeriodIsNoFault) {
  for (RobotConfig robot : {with_dynamixel(), robot_named("so101")}) {
    auto options = drivers::driver_config_from(robot, "").servo;
    options.period_us = 100000;
    const bool is_dynamixel = drivers::driver_config_from(robot, "").name == "dynamixel";
    std::unique_ptr<drivers::ServoEmulator> emulator;
    std::unique_ptr<drivers::Driver> driver;
    if (is_dynamixel) {
      emulator = std::make_unique<drivers::DynamixelEmulator>(robot.chain, JointVector::Zero(5), options);
      driver = std::make_unique<drivers::DynamixelDriver>(5, options);
    } else {
      emulator = std::make_unique<drivers::FeetechEmulator>(robot.chain, JointVector::Zero(5), options);
      driver = std::make_unique<drivers::FeetechDriver>(5, options);
    }
    drivers::WireOutbox to_robot, to_driver;
    driver->enable({0, 0}, to_robot);
    driver->link_changed(0, true, {0, 0}, to_robot);
    for (int64_t us = 1000; us < 5000000; us += 1000) {
      for (const auto& message : std::exchange(to_robot, {})) emulator->receive(0, message.bytes, {us, us}, to_driver);
      for (const auto& message : std::exchange(to_driver, {})) driver->receive(0, message.bytes, {us, us}, to_robot);
      if (driver->status().phase == drivers::DriverStatus::Phase::kReady)
        driver->command(JointVector::Constant(5, 0.1), JointVector::Zero(5), us, {us, us}, to_robot);
      driver->tick({us, us}, to_robot);
      emulator->tick({us, us}, to_driver);
    }
    EXPECT_EQ(driver->status().text, "ready");
    EXPECT_NEAR(emulator->position()[0], 0.1, 2e-3);
  }
}

// One unit of a Dynamixel's velocity is 0.229 rpm, 0.024 rad/s: more than 1 % of the limit of a gentle arm, which is
// the bridge's standstill. A motor at rest reports 0 or one unit.
TEST(Dynamixel, OneUnitOfVelocityIsStandstill) {
  drivers::DynamixelDriver driver(2, {.motor_ids = {1, 2}});
  drivers::WireOutbox out;
  driver.link_changed(0, true, {0, 0}, out);
  const auto measure = [&](int velocity) {
    for (const uint8_t id : {1, 2}) {
      dynamixel::Packet status{id, dynamixel::kStatus, {0}};
      dynamixel::put(status.parameters, velocity, 4);
      dynamixel::put(status.parameters, 2048, 4);
      driver.receive(0, dynamixel::encode(status), {0, 0}, out);
    }
    driver.tick({1000000 * (velocity + 10), 0}, out);
    return driver.take_reading()->velocity[1];
  };
  EXPECT_EQ(measure(-1), 0);
  EXPECT_EQ(measure(1), 0);
  EXPECT_NEAR(measure(2), 2 * 0.229 * 2 * std::numbers::pi / 60, 1e-9);
}

TEST(ServoBus, NamesTheMotorsThatDoNotAnswer) {
  drivers::FeetechDriver driver(3, {.motor_ids = {1, 4, 9}});
  drivers::WireOutbox out;
  driver.link_changed(0, true, {0, 0}, out);
  int64_t us = 0;
  const auto cycles = [&](int count, std::vector<uint8_t> ids) {
    for (int k = 0; k < count; ++k) {
      driver.tick({us += 8000, us}, out);
      for (const uint8_t id : ids) driver.receive(0, feetech::encode({id, 0, {0, 8, 0, 0}}), {us, us}, out);
    }
  };
  cycles(3, {1});
  EXPECT_EQ(driver.status().text, "waiting for an answer of motor 4, motor 9");
  cycles(3, {1, 4, 9});
  EXPECT_EQ(driver.status().text, "waiting for the position limits of all motors");
  cycles(20, {1, 4});
  EXPECT_EQ(driver.status().text, "motor 9 does not answer; then multireach-robot reset");
  // The driver was not scheduled: no motor is to blame.
  driver.reset({us, us}, out);
  cycles(6, {1, 4, 9});
  us += 500000;
  cycles(3, {1, 4, 9});
  EXPECT_EQ(driver.status().phase, drivers::DriverStatus::Phase::kWaiting) << driver.status().text;
}

TEST(ServoBus, ANoisyLineIsNoFault) {
  DriverLoop loop(robot_named("so101"));
  loop.run(3000);
  loop.faults.corruption = 0.02;
  loop.run(10000);
  EXPECT_GT(loop.faults.lost, 10);
  EXPECT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.driver().state();
}

}  // namespace
}  // namespace multireach::testing
