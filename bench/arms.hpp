#pragma once

#include <fstream>
#include <numbers>
#include <sstream>

#include "kinematics/urdf_chain.hpp"

namespace multireach::bench {

inline Chain hoap2() {
  std::ifstream file(MULTIREACH_SOURCE_DIR "/robots/hoap2/hoap2.urdf");
  std::stringstream text;
  text << file.rdbuf();
  return chain_from_urdf(text.str(), "torso", "right_hand");
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

}  // namespace multireach::bench
