#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/obstacles_t.hpp>
#include <multireach/perturbation_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <multireach/sim_step_t.hpp>
#include <multireach/target_t.hpp>

#include "numeric/random.hpp"
#include "runtime/channels.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/log/log_edit.hpp"
#include "tools/replay/bisect.hpp"
#include "tools/replay/message_difference.hpp"
#include "tools/replay/run.hpp"
#include "tools/replay/verify.hpp"

namespace multireach {
namespace {

const std::string kSource = MULTIREACH_SOURCE_DIR;
const std::string kSession = kSource + "/logs/reach.lcm";

ReplayOptions options_for(const std::string& session, double until_s) {
  return {.session = session,
          .from = replay_source(session),
          .robot = ReplayRobot::kIdeal,
          .config = RobotConfig::load(kSource + "/robots/hoap2/robot.yaml"),
          .vision = VisionConfig::load(kSource + "/robots/hoap2/vision.yaml"),
          .until_s = until_s,
          .threads = 1};
}

NodeConfigs configs() {
  const ReplayOptions options = options_for(kSession, 1);
  return {options.config, options.vision};
}

class Replay : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  /// Replays into a log of this name.
  ReplayResult run(const ReplayOptions& options, const std::string& name) const {
    LogWriter log(path(name));
    const ReplayResult result = replay(
        options,
        [&](int64_t at, std::string_view channel, std::span<const uint8_t> bytes, bool) {
          log.write(1'000'000'000 + at, channel, bytes);
        },
        nullptr);
    log.close();
    return result;
  }

  static Verification verified(const std::string& log) {
    return verify(log, configs(), [](double) {});
  }

  const testing::TemporaryFolder folder_;
};

TEST_F(Replay, GivesTheSameBytesWithAnyNumberOfThreads) {
  ReplayOptions options = options_for(kSession, 2);
  const ReplayResult one = run(options, "one");
  EXPECT_EQ(one.channels.at("TARGET").messages, 60);
  EXPECT_GE(one.channels.at("JOINT_COMMAND").messages, 1990);
  for (const int threads : {2, 3, 8}) {
    options.threads = threads;
    EXPECT_EQ(run(options, "several").digest, one.digest) << threads;
    EXPECT_EQ(read_text_file(path("one")), read_text_file(path("several")));
  }
}

TEST_F(Replay, DamagedImagesDoNotOutliveThemselves) {
  LogReader reader(kSession);
  LogWriter writer(path("garbled"));
  const CounterRandom random(13);
  uint64_t counter = 0;
  int64_t pairs = 0;
  while (const auto event = reader.next()) {
    std::vector<uint8_t> bytes(event->data.begin(), event->data.end());
    if (event->channel == channel::kStereoImages && pairs++ % 2 == 1) {
      const uint64_t changes = 1 + random.bits(counter++) % 19;
      // In the left image's JPEG, which begins after some forty bytes; half of them in its tables.
      for (uint64_t k = 0; k < changes; ++k) {
        const size_t reach = k % 2 ? 600 : bytes.size() / 3;
        const size_t at = 60 + random.bits(counter++) % reach;
        bytes[at] = static_cast<uint8_t>(random.bits(counter++));
      }
    }
    writer.write(event->utime, event->channel, bytes);
  }
  writer.close();
  ReplayOptions options = options_for(path("garbled"), 4);
  const ReplayResult one = run(options, "one");
  for (const int threads : {2, 5}) {
    options.threads = threads;
    EXPECT_EQ(run(options, "several").digest, one.digest) << threads;
  }
  LogReader log(path("one"));
  int64_t tracked = 0;
  while (const auto event = log.next()) {
    if (event->channel != channel::kTarget) continue;
    const auto target = decode<target_t>(event->data);
    tracked += target->pair_sequence % 2 == 0 && target->status == target_t::STATUS_TRACKED;
  }
  EXPECT_EQ(tracked, 60) << "every other pair is whole";
}

TEST_F(Replay, OfAReplayIsTheReplay) {
  const ReplayOptions options = options_for(kSession, 2);
  const ReplayResult first = run(options, "first");
  EXPECT_EQ(run(options_for(path("first"), 2), "second").digest, first.digest);
  EXPECT_EQ(read_text_file(path("first")), read_text_file(path("second")));
}

TEST_F(Replay, FromTargetsGivesTheSameSetPoints) {
  ReplayOptions options = options_for(kSession, 2);
  const ReplayResult from_images = run(options, "log");
  options.session = path("log");
  options.from = ReplayFrom::kTargets;
  const ReplayResult from_targets = run(options, "other");
  for (const char* channel : {"JOINT_SETPOINT", "CONTROLLER_STATE", "JOINT_COMMAND", "ROBOT_STATE"}) {
    EXPECT_EQ(from_targets.channels.at(channel).digest, from_images.channels.at(channel).digest) << channel;
  }
}

TEST_F(Replay, IsVerified) {
  for (const ReplayRobot robot : {ReplayRobot::kIdeal, ReplayRobot::kSimulated}) {
    ReplayOptions options = options_for(kSession, 3);
    options.robot = robot;
    const ReplayResult result = run(options, "log");
    const Verification verification = verified(path("log"));
    EXPECT_TRUE(verification.holds()) << verification.first->sentence();
    EXPECT_TRUE(verification.notes.empty()) << verification.notes.front();
    for (const auto& [name, channel] : result.channels) {
      EXPECT_EQ(verification.channels.at(name).equal, channel.messages) << name;
      EXPECT_EQ(verification.channels.at(name).unchecked, 0) << name;
    }
  }
}

/// Writes the log again with one byte of one computed message changed, and says where.
struct Change {
  std::string channel;
  int64_t event = 0;
};
Change change_a_byte(const std::string& from, const std::string& to, const CounterRandom& random, uint64_t& counter) {
  LogReader reader(from);
  std::vector<int64_t> candidates;
  int64_t number = 0;
  const auto computed = [](std::string_view channel) {
    return channel != channel::kStereoImages && channel != channel::kTargetTruth && channel != channel::kObstacles &&
           channel != channel::kPerturbation;
  };
  while (const auto event = reader.next()) {
    if (computed(event->channel)) candidates.push_back(number);
    ++number;
  }
  const int64_t chosen = candidates[random.bits(counter++) % candidates.size()];
  reader.rewind();
  LogWriter writer(to);
  Change change{.channel = "", .event = chosen};
  number = 0;
  while (const auto event = reader.next()) {
    std::vector<uint8_t> bytes(event->data.begin(), event->data.end());
    if (number++ == chosen) {
      const size_t at = random.bits(counter++) % bytes.size();
      bytes[at] = static_cast<uint8_t>(bytes[at] + 1 + random.bits(counter++) % 255);
      change.channel = event->channel;
    }
    writer.write(event->utime, event->channel, bytes);
  }
  writer.close();
  return change;
}

/// MULTIREACH_CHANGES: how many; MULTIREACH_CHANGED_LOG: of a log of one's own, as one recorded live.
TEST_F(Replay, VerifyFindsEveryChangedByte) {
  const char* asked = std::getenv("MULTIREACH_CHANGES");
  const char* given = std::getenv("MULTIREACH_CHANGED_LOG");
  const int changes = asked ? std::atoi(asked) : 150;
  std::string log = given ? given : path("log");
  if (!given) {
    ReplayOptions options = options_for(kSession, 0.5);
    options.robot = ReplayRobot::kSimulated;
    run(options, "log");
  }
  constexpr uint64_t kSeed = 11;
  const CounterRandom random(kSeed);
  uint64_t counter = 0;
  for (int k = 0; k < changes; ++k) {
    const Change change = change_a_byte(log, path("changed"), random, counter);
    const Verification verification = verified(path("changed"));
    ASSERT_FALSE(verification.holds()) << "seed " << kSeed << ", change " << k << " of " << change.channel;
    EXPECT_EQ(verification.first->channel, change.channel) << "seed " << kSeed << ", change " << k;
    EXPECT_EQ(verification.first->event, change.event);
  }
}

TEST_F(Replay, VerifySaysWhichFieldDiffersAndHow) {
  run(options_for(kSession, 1), "log");
  LogReader reader(path("log"));
  LogWriter writer(path("changed"));
  while (const auto event = reader.next()) {
    auto setpoint = event->channel == channel::kJointSetpoint ? decode<joint_setpoint_t>(event->data) : std::nullopt;
    if (setpoint && setpoint->sequence == 7) {
      setpoint->joint_position[2] = 0.5;
      writer.write(event->utime, event->channel, *encode(*setpoint));
    } else {
      writer.write(event->utime, event->channel, event->data);
    }
  }
  writer.close();
  const Verification verification = verified(path("changed"));
  ASSERT_TRUE(verification.first);
  EXPECT_EQ(verification.first->channel, "JOINT_SETPOINT");
  EXPECT_EQ(verification.first->node, "controller");
  EXPECT_EQ(verification.first->sequence, 7);
  EXPECT_EQ(verification.first->field, "joint_position[2]");
  EXPECT_EQ(verification.first->recorded, "0.5");
  EXPECT_NE(verification.first->sentence().find("JOINT_SETPOINT 7 (event "), std::string::npos);
  EXPECT_EQ(verification.channels.at("JOINT_SETPOINT").different, 1);
  EXPECT_EQ(verification.channels.at("JOINT_COMMAND").different, 0) << "the bridge got what the controller had sent";
}

TEST_F(Replay, VerifyDoesWithoutWhatTheRecorderLost) {
  ReplayOptions options = options_for(kSession, 3);
  run(options, "log");
  LogReader reader(path("log"));
  LogWriter writer(path("gaps"));
  const CounterRandom random(12);
  uint64_t counter = 0;
  while (const auto event = reader.next()) {
    const bool may_go = event->channel == channel::kTarget || event->channel == channel::kJointSetpoint ||
                        event->channel == channel::kJointCommand;
    if (may_go && random.uniform(counter++) < 0.3) continue;
    writer.write(event->utime, event->channel, event->data);
  }
  writer.close();
  const Verification verification = verified(path("gaps"));
  EXPECT_TRUE(verification.holds()) << verification.first->sentence();
  for (const auto& [name, channel] : verification.channels) EXPECT_EQ(channel.unchecked, 0) << name;
}

TEST_F(Replay, VerifySaysWhatItCannotCheck) {
  run(options_for(kSession, 2), "log");
  LogReader reader(path("log"));
  LogWriter writer(path("gap"));
  int64_t images = 0;
  while (const auto event = reader.next()) {
    if (event->channel == channel::kStereoImages && ++images == 30) continue;
    writer.write(event->utime, event->channel, event->data);
  }
  writer.close();
  const Verification verification = verified(path("gap"));
  EXPECT_TRUE(verification.holds());
  EXPECT_EQ(verification.channels.at("TARGET").unchecked, 1) << "vision goes on from what it sent";
  ASSERT_FALSE(verification.notes.empty());
  EXPECT_NE(verification.notes[0].find("vision: its messages for 1 of"), std::string::npos) << verification.notes[0];
  EXPECT_EQ(verification.channels.at("JOINT_SETPOINT").unchecked, 0) << "its targets are in the log";

  filter_log(path("log"), path("silent"), {"NODE_INPUTS"}, true);
  const Verification silent = verified(path("silent"));
  EXPECT_EQ(silent.channels.at("TARGET").unchecked, silent.channels.at("TARGET").messages);
  EXPECT_TRUE(silent.nothing_checked());
}

TEST_F(Replay, VerifyTakesALogThatBeginsInTheMiddle) {
  ReplayOptions options = options_for(kSession, 4);
  options.robot = ReplayRobot::kSimulated;
  run(options, "log");
  cut_log(path("log"), path("late"), 2, 9);
  const Verification verification = verified(path("late"));
  EXPECT_TRUE(verification.holds()) << verification.first->sentence();
  EXPECT_EQ(verification.channels.at("TARGET").unchecked, 1) << "it says all that vision remembers";
  EXPECT_LE(verification.channels.at("ROBOT_STATE").unchecked, 3) << "nor does the robot, with its state";
  EXPECT_GT(verification.channels.at("JOINT_SETPOINT").unchecked, 0);
}

/// What comes before the first tick: the state that the arm starts from, the target, and a state measured after it.
TEST_F(Replay, VerifyWithMeasuredFeedback) {
  std::filesystem::copy(kSource + "/robots/hoap2", path("robot"));
  std::string yaml = read_text_file(path("robot") + "/robot.yaml");
  yaml.replace(yaml.find("feedback: open"), 14, "feedback: measured");
  write_text_file(path("robot") + "/robot.yaml", yaml);
  ReplayOptions options = options_for(kSession, 2);
  options.config = RobotConfig::load(path("robot") + "/robot.yaml");
  run(options, "ideal");
  // States at a thousand times a second, some of them between the target and the tick.
  LogReader reader(path("ideal"));
  LogWriter writer(path("states"));
  std::vector<uint8_t> state;
  while (const auto event = reader.next()) {
    if (event->channel == channel::kRobotState) state.assign(event->data.begin(), event->data.end());
    writer.write(event->utime, event->channel, event->data);
    if (event->channel == channel::kTarget && !state.empty()) writer.write(event->utime, channel::kRobotState, state);
  }
  writer.close();
  options.session = path("states");
  options.from = ReplayFrom::kTargets;
  options.robot = ReplayRobot::kRecorded;
  run(options, "log");
  const Verification verification = verify(path("log"), {options.config, options.vision}, [](double) {});
  EXPECT_TRUE(verification.holds()) << verification.first->sentence();
  EXPECT_GT(verification.channels.at("JOINT_SETPOINT").equal, 30);
}

TEST_F(Replay, TakesObstaclesAndPushesWhereTheyWereRecorded) {
  LogReader reader(kSession);
  LogWriter writer(path("session"));
  int64_t images = 0;
  while (const auto event = reader.next()) {
    writer.write(event->utime, event->channel, event->data);
    if (event->channel == channel::kStereoImages && ++images == 40) {
      obstacles_t obstacles{};
      obstacle_t sphere{};
      sphere.shape = obstacle_t::SPHERE;
      sphere.position_m[0] = 0.1;
      sphere.position_m[1] = -0.12;
      sphere.position_m[2] = 0.1;
      sphere.size_m[0] = 0.03;
      sphere.orientation_wxyz[0] = 1;
      obstacles.num_obstacles = 1;
      obstacles.obstacles = {sphere};
      writer.write(event->utime + 5000, channel::kObstacles, *encode(obstacles));
      perturbation_t push{};
      push.link_name = "right_hand";
      push.force_n[0] = 5;
      push.duration_us = 100000;
      writer.write(event->utime + 9000, channel::kPerturbation, *encode(push));
    }
  }
  writer.close();
  ReplayOptions options = options_for(path("session"), 3);
  options.robot = ReplayRobot::kSimulated;
  run(options, "log");
  const Verification verification = verified(path("log"));
  EXPECT_TRUE(verification.holds()) << verification.first->sentence();
  EXPECT_EQ(verification.channels.at("ROBOT_STATE").unchecked, 0);
  LogReader log(path("log"));
  int64_t pushed = 0, sequence = -1;
  while (const auto event = log.next()) {
    if (event->channel == channel::kSimStep) pushed += !decode<sim_step_t>(event->data)->pushed_link.empty();
    if (event->channel == channel::kJointSetpoint) sequence = decode<joint_setpoint_t>(event->data)->obstacles_sequence;
  }
  EXPECT_EQ(pushed, 20) << "states, at 200 Hz";
  EXPECT_EQ(sequence, 0);
}

TEST_F(Replay, GoesThroughALogThatWasPlayedTwice) {
  cut_log(kSession, path("part"), 0, 1);
  LogWriter writer(path("twice"));
  int64_t later = 0;
  for (int round = 0; round < 2; ++round) {
    LogReader reader(path("part"));
    while (const auto event = reader.next()) writer.write(event->utime + later, event->channel, event->data);
    later += 5'000'000;
  }
  writer.close();
  const ReplayResult result = run(options_for(path("twice"), 1e9), "log");
  EXPECT_EQ(result.channels.at("TARGET").messages, 60);
  EXPECT_NEAR(result.span_s, 5 + 29.0 / 30, 0.02) << "the recorder's clock says how long it was between";
  EXPECT_NEAR(static_cast<double>(result.channels.at("JOINT_COMMAND").messages), 6500, 60);
  const Verification verification = verified(path("log"));
  EXPECT_TRUE(verification.holds()) << verification.first->sentence();
}

TEST_F(Replay, BisectNamesTheStageThatParted) {
  ReplayOptions options = options_for(kSession, 2);
  run(options, "old");
  run(options, "same");
  const auto none = [](double) {};
  EXPECT_FALSE(bisect(path("old"), path("same"), false, none).first);

  // Another gain in the controller's file.
  std::filesystem::copy(kSource + "/robots/hoap2", path("robot"));
  std::string yaml = read_text_file(path("robot") + "/robot.yaml");
  const std::string gain = "alpha_per_step: 0.08 ";
  ASSERT_NE(yaml.find(gain), std::string::npos);
  yaml.replace(yaml.find(gain), gain.size(), "alpha_per_step: 0.0801 ");
  write_text_file(path("robot") + "/robot.yaml", yaml);
  options.config = RobotConfig::load(path("robot") + "/robot.yaml");
  run(options, "gain");
  Comparison comparison = bisect(path("old"), path("gain"), false, none);
  ASSERT_TRUE(comparison.first);
  EXPECT_EQ(comparison.first->node, "controller");
  EXPECT_EQ(comparison.first->sequence, 0);
  EXPECT_EQ(comparison.first->cause, "its inputs are the same; its configuration differs");
  EXPECT_EQ(comparison.channels.at("TARGET").different, 0);

  // Another image: the session itself.
  LogReader reader(path("old"));
  LogWriter writer(path("image"));
  while (const auto event = reader.next()) {
    std::vector<uint8_t> bytes(event->data.begin(), event->data.end());
    if (event->channel == channel::kStereoImages) bytes[bytes.size() / 2] ^= 1;
    writer.write(event->utime, event->channel, bytes);
  }
  writer.close();
  comparison = bisect(path("old"), path("image"), false, none);
  EXPECT_EQ(comparison.first->channel, "STEREO_IMAGES");
  EXPECT_EQ(comparison.first->node, "");

  // What a recorder lost.
  filter_log(path("old"), path("part"), {"JOINT_COMMAND"}, true);
  EXPECT_FALSE(bisect(path("old"), path("part"), true, none).first);
  EXPECT_EQ(bisect(path("old"), path("part"), false, none).first->channel, "JOINT_COMMAND");
  EXPECT_TRUE(bisect(path("part"), path("old"), false, none).first);
}

TEST(MessageDifference, NamesTheField) {
  joint_setpoint_t a{};
  a.num_joints = 2;
  a.joint_name = {"one", "two"};
  a.joint_position = {0.25, -0.0};
  a.joint_velocity = {1, 2};
  joint_setpoint_t b = a;
  b.joint_position[0] = 0.5;
  MessageDifference difference = difference_of(*encode(a), *encode(b));
  EXPECT_EQ(difference.field, "joint_position[0]");
  EXPECT_EQ(difference.first, "0.25");
  EXPECT_EQ(difference.second, "0.5");
  b = a;
  b.joint_position[1] = 0.0;
  difference = difference_of(*encode(a), *encode(b));
  EXPECT_EQ(difference.field, "joint_position[1]");
  EXPECT_EQ(difference.first, "-0");
  b.joint_name[1] = "three";
  EXPECT_EQ(difference_of(*encode(a), *encode(b)).field, "joint_name[1]");
  auto cut = *encode(a);
  cut.pop_back();
  EXPECT_EQ(difference_of(*encode(a), cut).second, "the message has ended");
}

}  // namespace
}  // namespace multireach
