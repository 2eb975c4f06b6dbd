// Universal Robots: the bytes of RTDE against those in the tests of Universal Robots' own client library, start-up, the
// program, protective stops.
#include <gtest/gtest.h>

#include <cmath>

#include "robot_bridge/drivers/emulators/ur_emulator.hpp"
#include "robot_bridge/drivers/ur_driver.hpp"
#include "tests/robot_bridge/drivers/driver_loop.hpp"

namespace multireach::testing {
namespace {

namespace rtde = drivers::rtde;
using drivers::WireOutbox;
using Bytes = std::vector<uint8_t>;

// Bytes as in Universal_Robots_Client_Library, tests/test_rtde_*.cpp.
TEST(Rtde, WritesTheBytesOfTheMakersLibrary) {
  EXPECT_EQ(rtde::request_version(), (Bytes{0x00, 0x05, 0x56, 0x00, 0x02}));
  EXPECT_EQ(rtde::setup_outputs(500, "actual_q,actual_qd"),
            (Bytes{0x00, 0x1d, 0x4f, 0x40, 0x7f, 0x40, 0x00, 0x00, 0x00, 0x00, 0x00, 0x61, 0x63, 0x74, 0x75,
                   0x61, 0x6c, 0x5f, 0x71, 0x2c, 0x61, 0x63, 0x74, 0x75, 0x61, 0x6c, 0x5f, 0x71, 0x64}));
  EXPECT_EQ(rtde::Writer().i32(-2341).bytes(), (Bytes{0xFF, 0xFF, 0xF6, 0xDB}));
  EXPECT_EQ(rtde::Writer().i32(2341).bytes(), (Bytes{0x00, 0x00, 0x09, 0x25}));
}

TEST(Rtde, ReadsTheBytesOfTheMakersLibrary) {
  rtde::Stream stream;
  stream.add(Bytes{0x00, 0x14, 0x55, 0x01, 0x40, 0xd0, 0x07, 0x0d, 0x2f, 0x1a});
  EXPECT_FALSE(stream.next()) << "half a package";
  stream.add(Bytes{0x9f, 0xbe, 0x3f, 0xf0, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x04, 0x53, 0x01});
  const auto data = stream.next();
  ASSERT_TRUE(data);
  EXPECT_EQ(data->type, rtde::Type::kData);
  rtde::Reader reader(data->payload);
  EXPECT_EQ(reader.u8(), 1);
  EXPECT_NEAR(reader.real(), 16412.2, 0.1);
  EXPECT_EQ(reader.real(), 1.0);
  EXPECT_TRUE(reader.at_end());
  EXPECT_EQ(reader.i32(), 0);
  EXPECT_FALSE(reader.complete());
  const auto started = stream.next();
  ASSERT_TRUE(started);
  EXPECT_EQ(started->type, rtde::Type::kStart);
  EXPECT_FALSE(stream.next());
  stream.add(Bytes{0x00, 0x02, 0x53});
  EXPECT_TRUE(stream.broken());
}

TEST(Rtde, ReadsTheJointsOfARecordedPackage) {
  const Bytes payload{0x01, 0x40, 0xd0, 0x75, 0x8c, 0x49, 0xba, 0x5e, 0x35, 0xbf, 0xf9, 0x9c, 0x77, 0xd1, 0x10,
                      0xb4, 0x60, 0xbf, 0xfb, 0xa2, 0x33, 0xd1, 0x10, 0xb4, 0x60, 0xc0, 0x01, 0x9f, 0xbe, 0x68,
                      0x88, 0x5a, 0x30, 0xbf, 0xe9, 0xdb, 0x22, 0xa2, 0x21, 0x68, 0xc0, 0x3f, 0xf9, 0x85, 0x87,
                      0xa0, 0x00, 0x00, 0x00, 0xbf, 0x9f, 0xbe, 0x74, 0x44, 0x2d, 0x18, 0x00};
  rtde::Reader reader(payload);
  EXPECT_EQ(reader.u8(), 1);
  EXPECT_NEAR(reader.real(), 16854.1919, 1e-4);
  for (const double q : {-1.6007, -1.7271, -2.203, -0.808, 1.5951, -0.031}) EXPECT_NEAR(reader.real(), q, 1e-4);
}

TEST(UrProgram, EndsAfterTwentyMillisecondsOfSilenceOnBothSeries) {
  EXPECT_NE(drivers::ur_program({.e_series = true}, 7).find("while silent < 10:"), std::string::npos);
  EXPECT_NE(drivers::ur_program({.e_series = false}, 7).find("while silent < 3:"), std::string::npos);
  EXPECT_NE(drivers::ur_program({.e_series = true}, 7).find("servoj(q, 0, 0, 0.002, 0.03, 500)"), std::string::npos);
  EXPECT_NE(drivers::ur_program({}, 7).find("write_output_integer_register(24, 7)"), std::string::npos);
}

// Universal Robots' client library asks for the software's version, sets the outputs up, starts and pauses them to see
// that the robot has booted, and then sets its inputs up.
TEST(UrEmulator, ServesAClientThatStartsBeforeItSetsItsInputsUp) {
  drivers::UrEmulator emulator(robot_named("ur5e").chain, JointVector::Zero(6), true);
  WireOutbox out;
  const auto answers = [&](rtde::Type type, const Bytes& payload) {
    out.clear();
    emulator.receive(0, rtde::encode(type, payload), {0, 0}, out);
    return out.size() == 1 ? out[0].bytes : Bytes{};
  };
  const auto sent = [&] {
    out.clear();
    for (int ms = 0; ms < 20; ++ms) emulator.tick({0, 0}, out);
    return out.size();
  };
  answers(rtde::Type::kVersion, {0, 2});
  const Bytes version = answers(rtde::Type::kController, {});
  ASSERT_EQ(version.size(), 19U);
  EXPECT_EQ(version[6], 5) << "e-Series";
  answers(rtde::Type::kSetupOutputs, rtde::Writer().real(500).text("timestamp,actual_q").bytes());
  EXPECT_EQ(answers(rtde::Type::kStart, {}), (Bytes{0, 4, 'S', 1}));
  EXPECT_EQ(sent(), 10U);
  EXPECT_EQ(answers(rtde::Type::kPause, {}), (Bytes{0, 4, 'P', 1}));
  EXPECT_EQ(sent(), 0U);
  EXPECT_EQ(answers(rtde::Type::kSetupInputs, rtde::Writer().text("input_int_register_30,no_such_input").bytes()),
            rtde::encode(rtde::Type::kSetupInputs, rtde::Writer().u8(0).text("INT32,NOT_FOUND").bytes()));
  EXPECT_EQ(answers(rtde::Type::kSetupInputs, rtde::Writer().text("input_double_register_31").bytes()),
            rtde::encode(rtde::Type::kSetupInputs, rtde::Writer().u8(1).text("DOUBLE").bytes()));
  EXPECT_EQ(answers(rtde::Type::kStart, {}), (Bytes{0, 4, 'S', 1}));
  EXPECT_EQ(sent(), 10U);
}

// As Universal Robots' own fake server does: it negotiates one recipe and sends the data under the number of another.
TEST(UrDriver, DataOfAnotherFormAreNamedAndConnectedAgain) {
  drivers::UrDriver driver({});
  WireOutbox out;
  driver.link_changed(0, true, {0, 0}, out);
  const auto answer = [&](rtde::Type type, const Bytes& payload, int64_t us) {
    driver.receive(0, rtde::encode(type, payload), {us, us}, out);
  };
  answer(rtde::Type::kVersion, {1}, 0);
  answer(rtde::Type::kSetupOutputs, rtde::Writer().u8(1).text("VECTOR6D,VECTOR6D,INT32,INT32,INT32").bytes(), 0);
  answer(rtde::Type::kSetupInputs,
         rtde::Writer().u8(1).text("INT32,INT32,DOUBLE,DOUBLE,DOUBLE,DOUBLE,DOUBLE,DOUBLE").bytes(), 0);
  answer(rtde::Type::kStart, {1}, 0);
  rtde::Writer data;
  data.u8(0);
  for (int k = 0; k < 12; ++k) data.real(0);
  data.i32(7).i32(1).i32(0);
  bool closes = false;
  for (int64_t us = 0; us < 3000000; us += 2000) {
    answer(rtde::Type::kData, data.bytes(), us);
    driver.tick({us, us}, out);
    for (const auto& message : std::exchange(out, {})) closes = closes || (message.link == 0 && message.close);
  }
  EXPECT_EQ(driver.status().phase, drivers::DriverStatus::Phase::kFault);
  EXPECT_NE(driver.status().text.find("port 30004: the data do not have the agreed form"), std::string::npos)
      << driver.status().text;
  EXPECT_TRUE(closes);
}

TEST(UrDriver, ADashboardServerThatEndsNoLineIsLeft) {
  drivers::UrDriver driver({});
  WireOutbox out;
  driver.link_changed(1, true, {0, 0}, out);
  out.clear();
  const Bytes text(1000, 'x');
  for (int k = 0; k < 10 && out.empty(); ++k) driver.receive(1, text, {0, 0}, out);
  ASSERT_EQ(out.size(), 1U);
  EXPECT_TRUE(out[0].close);
  EXPECT_EQ(out[0].link, 1U);
}

TEST(UrDriver, PowersTheRobotOnOnlyWhenItIsEnabled) {
  drivers::UrDriver driver({});
  const RobotConfig robot = robot_named("ur5e");
  drivers::UrEmulator emulator(robot.chain, JointVector::Zero(6), true);
  WireOutbox to_robot, to_driver;
  int64_t us = 0;
  for (size_t link = 0; link < 3; ++link) {
    emulator.link_changed(link, true, {0, 0}, to_driver);
    driver.link_changed(link, true, {0, 0}, to_robot);
  }
  const auto run = [&](int ms) {
    for (int k = 0; k < ms; ++k) {
      us += 1000;
      for (const auto& message : std::exchange(to_robot, {}))
        emulator.receive(message.link, message.bytes, {us, us}, to_driver);
      for (const auto& message : std::exchange(to_driver, {}))
        driver.receive(message.link, message.bytes, {us, us}, to_robot);
      driver.tick({us, us}, to_robot);
      emulator.tick({us, us}, to_driver);
    }
  };
  run(3000);
  EXPECT_EQ(driver.status().text, "waiting for multireach-robot enable");
  driver.enable({us, us}, to_robot);
  run(6000);
  EXPECT_EQ(driver.status().text, "ready");
  EXPECT_EQ(emulator.program(), drivers::ur_program({}, 1));
  // Registers that are not finite, which this driver never writes.
  rtde::Writer data;
  data.u8(1).i32(7).i32(1);
  for (int i = 0; i < 6; ++i) data.real(std::nan(""));
  emulator.receive(0, rtde::encode(rtde::Type::kData, data.bytes()), {us, us}, to_driver);
  for (int k = 0; k < 2; ++k) emulator.tick({us += 1000, us}, to_driver);
  EXPECT_EQ(emulator.fault(), "protective stop: servoj: a position that is not finite");
  EXPECT_TRUE(emulator.position().allFinite());
}

// A controller that is still booting, or hangs, accepts the connections and says nothing.
TEST(UrDriver, AControllerThatNeverAnswersIsNamedAndConnectedAgain) {
  drivers::UrDriver driver({});
  WireOutbox out;
  int64_t us = 0;
  const auto closes = [&](int64_t ms) {
    int count = 0;
    for (const int64_t end = us + ms * 1000; us < end;) {
      driver.tick({us += 1000, us}, out);
      for (const auto& message : std::exchange(out, {})) {
        if (!message.close || message.link != 0) continue;
        ++count;
        driver.link_changed(0, false, {us, us}, out);
        driver.link_changed(0, true, {us, us}, out);
      }
    }
    return count;
  };
  for (size_t link = 0; link < 3; ++link) driver.link_changed(link, true, {0, 0}, out);
  EXPECT_EQ(closes(1900), 0);
  EXPECT_EQ(driver.status().text, "starting RTDE");
  EXPECT_GE(closes(8000), 2);
  EXPECT_EQ(driver.status().phase, drivers::DriverStatus::Phase::kFault);
  EXPECT_NE(driver.status().text.find("port 30004, but does not answer"), std::string::npos) << driver.status().text;
  // At each step of the set-up: here it answers once, and no more.
  driver.receive(0, rtde::encode(rtde::Type::kVersion, rtde::Writer().u8(1).bytes()), {us, us}, out);
  EXPECT_GE(closes(4000), 1);
  EXPECT_EQ(driver.status().phase, drivers::DriverStatus::Phase::kFault);
}

TEST(UrDriver, RecoversWhenTheControllerAnswersAtLast) {
  const RobotConfig robot = robot_named("ur5e");
  drivers::UrDriver driver({});
  WireOutbox to_robot, to_driver;
  std::optional<drivers::UrEmulator> emulator;
  driver.enable({0, 0}, to_robot);
  for (size_t link = 0; link < 3; ++link) driver.link_changed(link, true, {0, 0}, to_robot);
  for (int64_t us = 1000; us < 20000000; us += 1000) {
    if (us == 5000000) {  // has booted; each connection is a new one
      emulator.emplace(robot.chain, JointVector::Zero(6), true);
      for (size_t link = 1; link < 3; ++link) emulator->link_changed(link, true, {us, us}, to_driver);
    }
    for (const auto& message : std::exchange(to_robot, {})) {
      if (message.close) {
        driver.link_changed(message.link, false, {us, us}, to_robot);
        driver.link_changed(message.link, true, {us, us}, to_robot);
        if (emulator) emulator->link_changed(message.link, true, {us, us}, to_driver);
      } else if (emulator) {
        emulator->receive(message.link, message.bytes, {us, us}, to_driver);
      }
    }
    for (const auto& message : std::exchange(to_driver, {}))
      driver.receive(message.link, message.bytes, {us, us}, to_robot);
    driver.tick({us, us}, to_robot);
    if (emulator) emulator->tick({us, us}, to_driver);
  }
  EXPECT_EQ(driver.status().text, "ready");
}

TEST(UrDriver, ADashboardServerThatNeverAnswersIsNamed) {
  const RobotConfig robot = robot_named("ur5e");
  drivers::UrDriver driver({});
  drivers::UrEmulator emulator(robot.chain, JointVector::Zero(6), true);
  WireOutbox to_robot, to_driver;
  driver.enable({0, 0}, to_robot);
  for (size_t link = 0; link < 3; ++link) driver.link_changed(link, true, {0, 0}, to_robot);
  emulator.link_changed(0, true, {0, 0}, to_driver);
  for (int64_t us = 1000; us < 12000000; us += 1000) {
    for (const auto& message : std::exchange(to_robot, {})) {
      if (message.link == 0) emulator.receive(0, message.bytes, {us, us}, to_driver);
    }
    for (const auto& message : std::exchange(to_driver, {}))
      driver.receive(message.link, message.bytes, {us, us}, to_robot);
    driver.tick({us, us}, to_robot);
    emulator.tick({us, us}, to_driver);
  }
  EXPECT_EQ(driver.status().phase, drivers::DriverStatus::Phase::kFault);
  EXPECT_NE(driver.status().text.find("port 29999"), std::string::npos) << driver.status().text;
}

TEST(UrDriver, AProtectiveStopIsUnlockedAfterFiveSeconds) {
  DriverLoop loop(robot_named("ur5e"));
  loop.run(12000);
  ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.driver().state();
  loop.emulator().collide();
  loop.run(1500);
  EXPECT_NE(loop.driver().state().find("protective stop"), std::string::npos);
  EXPECT_EQ(loop.bridge_state.state, bridge_state_t::FAULT);
  EXPECT_NE(loop.bridge_state.cause.find("protective stop"), std::string::npos) << loop.bridge_state.cause;
  EXPECT_TRUE(loop.ask(bridge_request_t::RESET));
  loop.run(2000);
  EXPECT_NE(loop.emulator().fault(), "") << "not within 5 s";
  loop.run(5000);
  EXPECT_EQ(loop.emulator().fault(), "");
  EXPECT_NE(loop.driver().state().find("ready"), std::string::npos) << loop.driver().state();
  loop.restart_controller();
  loop.run(1000);
  EXPECT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.bridge().state();
}

TEST(UrDriver, TheRobotStopsByItselfWhenTheDriverIsGone) {
  DriverLoop loop(robot_named("ur5"));
  loop.run(12000);
  ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.driver().state();
  loop.run(900);
  auto& emulator = dynamic_cast<drivers::UrEmulator&>(loop.emulator());
  EXPECT_NE(emulator.program(), "");
  loop.faults.cut = true;
  loop.run(40);
  EXPECT_EQ(emulator.program(), "") << "ended after 24 ms";
  loop.run(500);
  const JointVector there = emulator.position();
  loop.run(500);
  EXPECT_EQ(emulator.position(), there);
}

}  // namespace
}  // namespace multireach::testing
