#include "runtime/config.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <functional>

#include "controller/node/controller_node.hpp"
#include "robot_bridge/node/bridge_node.hpp"
#include "runtime/robot_config.hpp"
#include "tests/input_fault.hpp"
#include "tests/temporary_folder.hpp"

namespace multireach {
namespace {

class ConfigFile : public ::testing::Test {
 protected:
  Config load(const std::string& text) {
    write_text_file(path_, text);
    return Config::load(path_);
  }
  const testing::TemporaryFolder folder_;
  const std::string path_ = folder_ / "robot.yaml";
};

TEST_F(ConfigFile, NamesLineKeyAndBoundWhereTheBridgesDelayIsTooLongForTheTicks) {
  const auto message = [&](const std::string& rest) {
    write_text_file(path_, "robot: {urdf: " MULTIREACH_SOURCE_DIR
                           "/robots/hoap2/hoap2.urdf, base: torso, tip: right_hand}\n" +
                               rest);
    return testing::input_fault([&] { (void)bridge_options_from(RobotConfig::load(path_)); });
  };
  EXPECT_EQ(message("tick_ms: 20\nbridge:\n  delay_ms: 61\n"),
            path_ + ":4: key 'bridge.delay_ms' is '61'; expected at most 60, three times tick_ms");
  EXPECT_EQ(message("bridge:\n  delay_ms: 150\n"), "");
  // The default delay, 5 ms, with shorter ticks.
  EXPECT_EQ(message("tick_ms: 1.5\n"),
            path_ + ":2: key 'tick_ms' is '1.5'; expected at least 1.66667, a third of the bridge's delay_ms");
}

TEST_F(ConfigFile, GivesValuesAndDefaults) {
  const Config config = load("a: 1.5\nb: 3\nc: yes\nd: word\ne: [1, 2]\nf: {x: 1, y: 2}\n");
  EXPECT_EQ(config.number("a", 0, 2), 1.5);
  EXPECT_EQ(config.integer("b", 0, 9), 3);
  EXPECT_TRUE(config.flag("c"));
  EXPECT_EQ(config.choice("d", {"word", "other"}), "word");
  EXPECT_EQ(config.numbers("e", 2), (std::vector<double>{1, 2}));
  EXPECT_EQ(config.named_numbers("f").at("y"), 2);
  EXPECT_EQ(config.number("missing", 0, 1, 0.5), 0.5);
  EXPECT_NO_THROW(config.finish());
}

TEST_F(ConfigFile, OverridesReplaceValuesAndAreNamedInErrors) {
  const std::string text = "a: 1\nsection:\n  b: 2\nlist: [{c: 3}, {c: 4}]\n";
  const auto with = [&](const ConfigOverrides& overrides) { return Config::parse("f.yaml", text, overrides); };
  const Config set = with({{"a", "7"}, {"section.b", "[1, 2]"}, {"list[1].c", "8"}, {"more.deep.d", "9"}});
  EXPECT_EQ(set.number("a", 0, 10), 7);
  EXPECT_EQ(set.section("section").numbers("b", 2), (std::vector<double>{1, 2}));
  EXPECT_EQ(set.sections("list")[0].number("c", 0, 10), 3);
  EXPECT_EQ(set.sections("list")[1].number("c", 0, 10), 8);
  EXPECT_EQ(set.section("more").section("deep").number("d", 0, 10), 9);
  EXPECT_EQ(testing::input_fault([&] {
              with({{"a", "cat"}}).number("a", 0, 1);
            }),
            "f.yaml: key 'a' is 'cat'; expected a number from 0 to 1");
  EXPECT_EQ(testing::input_fault([&] {
              with({{"list[1].c", "x"}}).sections("list")[1].number("c", 0, 1);
            }),
            "f.yaml: key 'list[1].c' is 'x'; expected a number from 0 to 1");
  EXPECT_EQ(testing::input_fault([&] {
              with({{"section.other", "1"}}).section("section").finish();
            }),
            "f.yaml:3: key 'section.b' is not known; known here: ");
  EXPECT_EQ(testing::input_fault([&] {
              const Config section = with({{"section.other", "1"}}).section("section");
              section.number("b", 0, 10);
              section.finish();
            }),
            "f.yaml: key 'section.other' is not known; known here: b");
  EXPECT_EQ(testing::input_fault([&] {
              with({{"a.b", "1"}});
            }),
            "f.yaml: 'a.b' cannot be set: 'b' would be in a value that has no keys");
  EXPECT_EQ(testing::input_fault([&] {
              with({{"list[2].c", "1"}});
            }),
            "f.yaml: 'list[2].c' cannot be set: the list has 2 entries, counted from 0");
  for (const char* key : {"", ".", "a.", "a[", "a[]", "a[x]", "a[1", "[0]", "a[-1]"})
    EXPECT_NE(testing::input_fault([&] { with({{key, "1"}}); }).find("is not a key"), std::string::npos) << key;
  EXPECT_NE(testing::input_fault([&] {
              with({{"a", "[1"}});
            }).find("key 'a' is '[1'; expected a value in YAML"),
            std::string::npos);
  EXPECT_EQ(config_override_from("--set", "a.b=c=d").value, "c=d");
  for (const char* wrong : {"", "a", "=1", "a="})
    EXPECT_NE(testing::input_fault([&] { config_override_from("--set", wrong); }).find("expected KEY=VALUE"),
              std::string::npos);
}

TEST_F(ConfigFile, NamesFileLineAndKey) {
  const Config config = load("a: 1.5\nsection:\n  b: cat\n  misspelt: 1\nlist: [1, x]\n");
  EXPECT_EQ(testing::input_fault([&] { config.number("a", 2, 3); }),
            path_ + ":1: key 'a' is '1.5'; expected a number from 2 to 3");
  EXPECT_EQ(testing::input_fault([&] { config.section("section").number("b", 0, 1); }),
            path_ + ":3: key 'section.b' is 'cat'; expected a number from 0 to 1");
  EXPECT_EQ(testing::input_fault([&] { config.number("missing", 0, 1); }), path_ + ":1: key 'missing' is missing");
  EXPECT_NE(testing::input_fault([&] {
              const Config section = config.section("section");
              section.text("b");
              section.finish();
            }).find(":4: key 'section.misspelt' is not known"),
            std::string::npos);
  EXPECT_NE(testing::input_fault([&] {
              config.numbers("list", 2);
            }).find(":5: key 'list' expected a list of 2 finite numbers"),
            std::string::npos);
}

TEST_F(ConfigFile, RefusesWhatIsNoNumber) {
  const Config config = load("a: nan\nb: inf\nc: 1e400\nd: 2.5\n");
  for (const char* key : {"a", "b", "c"})
    EXPECT_NE(testing::input_fault([&] { config.number(key, -1e9, 1e9); }), "") << key;
  EXPECT_NE(testing::input_fault([&] { config.integer("d", 0, 9); }), "");
}

TEST_F(ConfigFile, RefusesBrokenFiles) {
  EXPECT_NE(testing::input_fault([&] { load("a: [1, 2"); }).find("is not valid YAML"), std::string::npos);
  EXPECT_NE(testing::input_fault([&] { load("- 1\n- 2\n"); }).find("must hold keys and values"), std::string::npos);
  EXPECT_NE(testing::input_fault([&] { load("a: 1\na: 2\n"); }).find(":2: key 'a' stands twice"), std::string::npos);
  EXPECT_NE(testing::input_fault([&] { load(""); }), "");
  EXPECT_NE(
      testing::input_fault([] { Config::load("/nowhere/file.yaml"); }).find("/nowhere/file.yaml: cannot be opened"),
      std::string::npos);
  EXPECT_NE(testing::input_fault([] { Config::load("/tmp"); }).find("is a folder"), std::string::npos);
}

TEST_F(ConfigFile, ARobotFileNamesWhatIsWrong) {
  const std::string urdf = MULTIREACH_SOURCE_DIR "/robots/hoap2/hoap2.urdf";
  const auto robot = [&](const std::string& text) {
    return testing::input_fault([&] {
      write_text_file(path_, text);
      RobotConfig::load(path_);
    });
  };
  EXPECT_EQ(robot("robot: {urdf: " + urdf + ", base: torso, tip: right_hand}\n"), "");
  EXPECT_NE(robot("robot: {urdf: " + urdf + ", base: torso, tip: foot}\n")
                .find(":1: key 'robot.tip' is 'foot'; expected a link of "),
            std::string::npos);
  EXPECT_NE(robot("robot: {urdf: nothing.urdf, base: torso, tip: right_hand}\n")
                .find(":1: key 'robot.urdf' is 'nothing.urdf'; expected an existing file"),
            std::string::npos);
  EXPECT_NE(
      robot("robot: {urdf: " + urdf + ", base: torso, tip: right_hand, speed: 3}\n").find("'robot.speed' is not known"),
      std::string::npos);
  const auto limits = [&](const std::string& keys) {
    return robot("robot: {urdf: " + urdf + ", base: torso, tip: right_hand, " + keys + "}\n");
  };
  EXPECT_EQ(limits("joint_acceleration_limits: [9, 9, 9, 9], joint_jerk_limits: [900, 900, 900, 900]"), "");
  EXPECT_NE(limits("joint_acceleration_limits: [1, 1, 1]").find("'robot.joint_acceleration_limits'"),
            std::string::npos);
  EXPECT_NE(limits("joint_jerk_limits: [1, 1, 1, 0]").find("'robot.joint_jerk_limits'"), std::string::npos);
  EXPECT_NE(robot("contoller: {}\nrobot: {urdf: " + urdf + ", base: torso, tip: right_hand}\n")
                .find("'contoller' is not known"),
            std::string::npos);
}

TEST_F(ConfigFile, LimitsThatLookLikeDegreesAreDoubted) {
  RobotConfig robot = RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/ur5e/robot.yaml");
  EXPECT_TRUE(doubts_about(robot).empty()) << doubts_about(robot).front();
  std::vector<Joint> joints = robot.chain.joints();
  std::vector<Eigen::Isometry3d> fixed;
  for (int i = 0; i <= robot.chain.size(); ++i) fixed.push_back(robot.chain.fixed(i));
  joints[0].lower = -360;
  joints[1].velocity = 180;
  robot.chain = Chain(std::move(joints), std::move(fixed), robot.chain.base(), robot.chain.tip());
  robot.joint_acceleration_limits = JointVector::Constant(6, 10);
  robot.joint_acceleration_limits[2] = 800;
  const std::vector<std::string> doubts = doubts_about(robot);
  ASSERT_EQ(doubts.size(), 3U);
  EXPECT_EQ(doubts[0], "joint 'shoulder_pan_joint': a position limit of -360 rad; in degrees? Angles are in radians");
  EXPECT_TRUE(doubts[1].starts_with("joint 'shoulder_lift_joint': a velocity limit of")) << doubts[1];
  EXPECT_TRUE(doubts[2].starts_with("joint 'elbow_joint': an acceleration limit")) << doubts[2];
}

TEST_F(ConfigFile, ABaseAndATipThatLookSwappedAreDoubted) {
  write_text_file(path_,
                  "robot: {urdf: " MULTIREACH_SOURCE_DIR "/robots/hoap2/hoap2.urdf, base: right_hand, tip: torso}\n");
  const std::vector<std::string> doubts = doubts_about(RobotConfig::load(path_));
  ASSERT_EQ(doubts.size(), 1U);
  EXPECT_NE(doubts[0].find("are they swapped?"), std::string::npos) << doubts[0];
}

TEST_F(ConfigFile, AControllerSectionNamesWhatIsWrong) {
  const auto controller = [&](const std::string& section) {
    return testing::input_fault([&] {
      write_text_file(path_, "robot: {urdf: " MULTIREACH_SOURCE_DIR
                             "/robots/hoap2/hoap2.urdf, base: torso, tip: right_hand}\ncontroller: {" +
                                 section + "}\n");
      ControllerNode node(RobotConfig::load(path_));
    });
  };
  EXPECT_EQ(controller("law: guarded, gamma_rad2_m2: 200, feedback: measured, "
                       "on_target_lost: stop, link_radius_m: 0.02, margin_m: 0.01, self_collision: false"),
            "");
  EXPECT_EQ(controller("law: paper, gamma_rad2_m2: 350, drift_m: 0.02"), "");
  const auto says = [&](const std::string& section, const std::string& words) {
    const std::string sentence = controller(section);
    EXPECT_NE(sentence.find(words), std::string::npos) << section << ": " << sentence;
  };
  EXPECT_EQ(controller("joint_weights: {right_EB: 3}, locked_joints: [right_SHR]"), "");
  says("joint_weights: {elbow: 3}", "and no 'elbow'");
  says("joint_weights: {right_EB: 0}", "weights from 0.001 to 1000");
  says("locked_joints: [elbow]", "and no 'elbow'");
  says("locked_joints: [right_SFE, right_SAA, right_SHR, right_EB]", "one that may move");
  says("law: paper, locked_joints: [right_EB]", "allowed only with law: guarded");
  says("law: papers", "law");
  says("law: guarded, drift_m: 0.02", "'controller.drift_m' is allowed only with law: paper");
  says("law: paper, link_radius_m: 0.02", "'controller.link_radius_m' is allowed only with law: guarded");
  says("beta_per_step: 0.03", "overshoot");
  EXPECT_EQ(controller("natural_frequency_rad_s: 8, damping_ratio: 1, steps_per_tick: 50"), "");
  says("damping_ratio: 0.99", "'controller.damping_ratio' is '0.99'; expected a number from 1 to 100");
  says("natural_frequency_rad_s: 8, alpha_per_step: 0.1", "natural_frequency_rad_s without alpha_per_step");
  says("law: paper, natural_frequency_rad_s: 8", "allowed only with law: guarded");
  says("task: pointing", "pointing_direction");
  says("task: pointing, pointing_direction: [0, 0, 0]", "a vector that is not zero");
  says("link_radius_m: -1", "link_radius_m");
  says("feedback: maybe", "feedback");
  says("rest_joint_position: [0, 0, 0, 2]", "right_EB");
}

TEST(WriteTextFile, LeavesTheOldFileWhenTheNewOneCannotBeWritten) {
  EXPECT_THROW(write_text_file("/nowhere/at/all", "text"), InputError);
  if (std::filesystem::exists("/dev/full")) {
    EXPECT_THROW(write_text_file("/dev/full", std::string(1 << 20, 'x')), OutputError);
  }
}

}  // namespace
}  // namespace multireach
