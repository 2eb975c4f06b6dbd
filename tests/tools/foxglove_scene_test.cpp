#include "tools/foxglove/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <multireach/robot_state_t.hpp>

#include "runtime/files.hpp"
#include "runtime/message.hpp"
#include "tests/input_fault.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/foxglove/schemas.hpp"

namespace multireach {
namespace {

using json = nlohmann::ordered_json;

constexpr int64_t kReceived = 1'700'000'000'500'000;

RobotConfig hoap2() {
  return RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml");
}

robot_state_t state_of(const Chain& chain, double angle) {
  robot_state_t state{};
  state.utime = 5000;  // the robot's own clock
  for (const Joint& joint : chain.joints()) {
    state.joint_name.push_back(joint.name);
    state.joint_position.push_back(angle);
  }
  state.num_joints = static_cast<int32_t>(state.joint_name.size());
  state.joint_velocity.resize(state.joint_name.size());
  state.joint_effort.resize(state.joint_name.size());
  return state;
}

Eigen::Vector3d vector_of(const json& v) {
  return {v["x"].get<double>(), v["y"].get<double>(), v["z"].get<double>()};
}

/// Every key of a message is a property of its schema, and the other way round.
void expect_fits(const json& value, const json& schema, const std::string& where) {
  if (schema["type"] == "array") {
    for (const json& each : value) expect_fits(each, schema["items"], where + "[]");
    return;
  }
  if (schema["type"] != "object") return;
  for (const auto& [key, inner] : value.items()) {
    ASSERT_TRUE(schema["properties"].contains(key)) << where << "." << key;
    expect_fits(inner, schema["properties"][key], where + "." + key);
  }
  EXPECT_EQ(value.size(), schema["properties"].size()) << where;
}

TEST(FoxgloveScene, FramesLeadToTheHandWhereTheChainHasIt) {
  const RobotConfig robot = hoap2();
  FoxgloveScene scene(robot, nullptr);
  const robot_state_t state = state_of(robot.chain, -0.3);
  const auto messages = scene.messages("ROBOT_STATE", *encode(state), kReceived);
  ASSERT_EQ(messages.size(), 2u);
  EXPECT_EQ(messages[0].topic, "/tf");
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  std::string frame = "torso";
  for (const json& each : messages[0].message["transforms"]) {
    EXPECT_EQ(each["parent_frame_id"], frame);
    frame = each["child_frame_id"];
    const json& q = each["rotation"];
    Eigen::Isometry3d step(
        Eigen::Quaterniond(q["w"].get<double>(), q["x"].get<double>(), q["y"].get<double>(), q["z"].get<double>()));
    step.pretranslate(vector_of(each["translation"]));
    X = X * step;
    EXPECT_EQ(each["timestamp"]["sec"], 1'700'000'000);
    EXPECT_EQ(each["timestamp"]["nsec"], 500'000'000);
  }
  EXPECT_EQ(frame, "right_hand");
  const JointVector theta = JointVector::Constant(robot.chain.size(), -0.3);
  EXPECT_TRUE(X.isApprox(robot.chain.pose(theta), 1e-12));
  EXPECT_TRUE(scene.messages("ROBOT_STATE", *encode(state), kReceived + 5000).empty()) << "at most 30 a second";
  EXPECT_FALSE(scene.messages("ROBOT_STATE", *encode(state), kReceived + 40000).empty());
  EXPECT_TRUE(
      FoxgloveScene(robot, nullptr).messages("ROBOT_STATE", *encode(state_of(robot.chain, NAN)), kReceived).empty());
}

TEST(FoxgloveScene, AJointAboveTheBaseHasAFrameOfItsOwnName) {
  const testing::TemporaryFolder folder;
  const std::string path = folder / "robot.yaml";
  write_text_file(
      path, "robot: {urdf: " MULTIREACH_SOURCE_DIR "/robots/hoap2/hoap2.urdf, base: right_hand, tip: left_hand}\n");
  const RobotConfig robot = RobotConfig::load(path);
  FoxgloveScene scene(robot, nullptr);
  const auto messages = scene.messages("ROBOT_STATE", *encode(state_of(robot.chain, -0.2)), kReceived);
  ASSERT_EQ(messages.size(), 2u);
  std::vector<std::string> frames;
  for (const json& each : messages[0].message["transforms"]) frames.push_back(each["child_frame_id"]);
  ASSERT_EQ(frames.size(), 9u);
  EXPECT_EQ(frames[0], "right_EB") << "moved from child to parent";
  EXPECT_EQ(frames[3], "right_SFE");
  EXPECT_EQ(frames[4], "left_shoulder_flexion");
  EXPECT_EQ(frames[8], "left_hand");
}

TEST(FoxgloveScene, ObstaclesAreDrawnAgainForThoseWhoComeLater) {
  const RobotConfig robot = hoap2();
  FoxgloveScene scene(robot, nullptr);
  obstacles_t obstacles{};
  obstacles.obstacles.resize(1);
  obstacles.num_obstacles = 1;
  obstacles.obstacles[0].size_m[0] = 0.1;
  EXPECT_EQ(scene.messages("OBSTACLES", *encode(obstacles), kReceived).size(), 1u);
  const auto drawn = [&](int64_t after_us) {
    const auto messages = scene.messages("ROBOT_STATE", *encode(state_of(robot.chain, 0)), kReceived + after_us);
    return messages.back().message["entities"].size();
  };
  EXPECT_EQ(drawn(500'000), 1u) << "the arm";
  EXPECT_EQ(drawn(1'100'000), 2u);
  EXPECT_EQ(drawn(1'200'000), 1u);
}

TEST(FoxgloveScene, ATargetIsAnEllipsoidUntilItIsLost) {
  FoxgloveScene scene(hoap2(), nullptr);
  target_t target{};
  target.name = "ball";
  target.status = target_t::STATUS_TRACKED;
  target.position_m[0] = 0.3;
  for (int i = 0; i < 3; ++i) target.covariance_m2[i][i] = i == 2 ? 0.04 * 0.04 : 0.01 * 0.01;
  const auto shown = scene.messages("TARGET", *encode(target), kReceived);
  ASSERT_EQ(shown.size(), 1u);
  const json& sphere = shown[0].message["entities"][0]["spheres"][0];
  EXPECT_EQ(vector_of(sphere["pose"]["position"]), Eigen::Vector3d(0.3, 0, 0));
  const Eigen::Vector3d size = vector_of(sphere["size"]);
  EXPECT_NEAR(size.maxCoeff(), 2 * 2 * 0.04, 1e-12) << "two standard deviations to each side";
  EXPECT_NEAR(size.minCoeff(), 2 * 2 * 0.01, 1e-12);
  target.status = target_t::STATUS_LOST;
  const auto lost = scene.messages("TARGET", *encode(target), kReceived);
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_EQ(lost[0].message["deletions"][0]["id"], "target ball");
  EXPECT_TRUE(scene.messages("TARGET", *encode(target), kReceived).empty());
}

TEST(FoxgloveScene, MessagesFitTheirSchemas) {
  const RobotConfig robot = hoap2();
  StereoRig rig;
  rig.left.width = rig.right.width = 320;
  rig.X_RL = rig.X_WL = Eigen::Isometry3d::Identity();
  FoxgloveScene scene(robot, &rig);
  target_t target{};
  target.status = target_t::STATUS_TRACKED;
  obstacles_t obstacles{};
  for (const int8_t shape : {obstacle_t::SPHERE, obstacle_t::CAPSULE, obstacle_t::BOX}) {
    obstacle_t each{};
    each.shape = shape;
    std::fill_n(each.size_m, 3, 0.1);
    obstacles.obstacles.push_back(each);
  }
  obstacles.num_obstacles = 3;
  images_t images{};
  images.images.resize(1);
  images.image_types = {images_t::LEFT};
  images.n_images = 1;
  images.images[0].pixelformat = image_t::PIXEL_FORMAT_MJPEG;
  std::vector<FoxgloveMessage> all = scene.messages("STEREO_IMAGES", *encode(images), kReceived);
  EXPECT_TRUE(all.empty()) << "no robot of this kind was seen yet";
  for (const auto& [channel, bytes] :
       {std::pair("ROBOT_STATE", *encode(state_of(robot.chain, 0))), std::pair("TARGET", *encode(target)),
        std::pair("OBSTACLES", *encode(obstacles)), std::pair("STEREO_IMAGES", *encode(images))}) {
    for (FoxgloveMessage& each : scene.messages(channel, bytes, kReceived)) all.push_back(std::move(each));
  }
  all.push_back(*foxglove_image("STEREO_IMAGES", images, 0));
  ASSERT_EQ(all.size(), 6u);
  for (const FoxgloveMessage& each : all) expect_fits(each.message, foxglove_schema(each.schema), each.schema);
  EXPECT_THROW(foxglove_schema("foxglove.Grid"), std::invalid_argument);
}

}  // namespace
}  // namespace multireach
