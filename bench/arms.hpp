#pragma once

#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "controller/collision/obstacle.hpp"
#include "kinematics/urdf_chain.hpp"
#include "numeric/random.hpp"

namespace multireach::bench {

struct ArmName {
  std::string name, urdf, base, tip;
};

/// The Hoap2, and the public arms of ../shared/robots, whether they are there or not.
inline std::vector<ArmName> default_arms() {
  const std::string here = MULTIREACH_SOURCE_DIR, beside = here + "/../shared/robots/";
  return {{"Hoap2", here + "/robots/hoap2/hoap2.urdf", "torso", "right_hand"},
          {"Panda", beside + "panda.urdf", "panda_link0", "panda_hand"},
          {"iiwa 14", beside + "iiwa14.urdf", "base", "iiwa_link_ee"},
          {"UR5", beside + "ur5_robot.urdf", "base_link", "ee_link"},
          {"Kinova j2s6s200", beside + "kinova.urdf", "j2s6s200_link_base", "j2s6s200_end_effector"},
          {"Baxter, left", beside + "baxter.urdf", "base", "left_gripper"}};
}

/// Throws std::invalid_argument when the file cannot be read or is no URDF with this chain.
inline Chain load(const ArmName& arm) {
  std::ifstream file(arm.urdf);
  if (!file) throw std::invalid_argument(arm.urdf + ": cannot be read");
  std::stringstream text;
  text << file.rdbuf();
  try {
    return chain_from_urdf(text.str(), arm.base, arm.tip);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(arm.urdf + ": " + error.what());
  }
}

inline Chain hoap2() {
  return load(default_arms().front());
}

/// A typical seven-joint arm: spherical shoulder, elbow, spherical wrist with an offset hand; about 0.9 m.
inline Chain seven_joints() {
  const double turn = std::numbers::pi / 2;
  std::vector<Joint> joints;
  std::vector<Eigen::Isometry3d> fixed;
  const double lengths[] = {0.34, 0, 0.4, 0, 0.4, 0, 0.126, 0.045};
  for (int i = 0; i < 7; ++i) {
    const bool swings = i % 2 == 1;
    joints.push_back({.name = "joint_" + std::to_string(i + 1),
                      .type = Joint::Type::kRevolute,
                      .axis = swings ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ(),
                      .lower = swings ? -2.09 : -2.96,
                      .upper = swings ? 2.09 : 2.96,
                      .velocity = turn,
                      .effort = 100});
  }
  for (const double length : lengths) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() = Eigen::Vector3d(0, 0, length);
    fixed.push_back(X);
  }
  return Chain(joints, fixed, "base", "hand");
}

/// Twenty obstacles of three shapes around the arm.
inline std::vector<controller::Obstacle> twenty_obstacles(const Chain& chain) {
  const CounterRandom random(3);
  std::vector<controller::Obstacle> obstacles;
  for (uint64_t k = 0; k < 20; ++k) {
    controller::Obstacle obstacle;
    obstacle.shape = static_cast<controller::Obstacle::Shape>(k % 3);
    for (uint64_t axis = 0; axis < 3; ++axis) {
      obstacle.X_WO.translation()[static_cast<Eigen::Index>(axis)] =
          chain.reach() * random.uniform(3 * k + axis, -1.2, 1.2);
    }
    obstacle.X_WO.translation() += chain.fixed(0).translation();
    obstacle.size = 0.08 * chain.reach() * Eigen::Vector3d::Ones();
    obstacles.push_back(obstacle);
  }
  return obstacles;
}

}  // namespace multireach::bench
