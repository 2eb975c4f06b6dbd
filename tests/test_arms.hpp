#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "kinematics/urdf_chain.hpp"
#include "numeric/random.hpp"

namespace multireach::testing {

struct ArmFile {
  std::string path, base, tip;
};

inline std::string file_text(const std::string& path) {
  std::ifstream in(path);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

inline ArmFile hoap2_file() {
  return {MULTIREACH_SOURCE_DIR "/robots/hoap2/hoap2.urdf", "torso", "right_hand"};
}

/// The public arms of ../shared/robots; empty if that folder does not exist.
inline std::vector<ArmFile> shared_arm_files() {
  const std::string folder = MULTIREACH_SHARED_DIR "/robots/";
  std::vector<ArmFile> files{{folder + "panda.urdf", "panda_link0", "panda_hand"},
                             {folder + "ur5_robot.urdf", "base_link", "ee_link"},
                             {folder + "kinova.urdf", "j2s6s200_link_base", "j2s6s200_end_effector"},
                             {folder + "baxter.urdf", "base", "left_gripper"},
                             {folder + "iiwa14.urdf", "base", "iiwa_link_ee"}};
  std::erase_if(files, [](const ArmFile& file) { return !std::filesystem::exists(file.path); });
  return files;
}

inline std::vector<ArmFile> all_arm_files() {
  std::vector<ArmFile> files = shared_arm_files();
  files.insert(files.begin(), hoap2_file());
  return files;
}

inline Chain load(const ArmFile& file) {
  return chain_from_urdf(file_text(file.path), file.base, file.tip);
}
inline Chain hoap2() {
  return load(hoap2_file());
}

struct NamedArm {
  std::string name;
  Chain chain;
};

/// An arm of seven revolute joints made for tests: spherical shoulder, elbow and spherical wrist (axes z y z y z y z),
/// links of 0.35, 0.3 and 0.1 m.
inline NamedArm seven_joint_arm() {
  std::vector<Joint> joints;
  joints.reserve(7);
  for (int i = 0; i < 7; ++i) {
    joints.push_back({.name = {static_cast<char>('a' + i)},
                      .axis = i % 2 == 0 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY(),
                      .lower = i % 2 == 0 ? -2.9 : -2.0,
                      .upper = i % 2 == 0 ? 2.9 : 2.0,
                      .velocity = 2,
                      .effort = 10});
  }
  std::vector<Eigen::Isometry3d> fixed(8, Eigen::Isometry3d::Identity());
  fixed[0].translation().z() = 0.3;
  fixed[3].translation().z() = 0.35;
  fixed[5].translation().z() = 0.3;
  fixed[7].translation().z() = 0.1;
  return {"seven joints", Chain(joints, fixed, "base", "hand")};
}

/// An arm of six revolute joints made for tests: three parallel axes and an offset wrist (axes z y y y z y), links of
/// 0.4 and 0.35 m.
inline NamedArm six_joint_arm() {
  std::vector<Joint> joints;
  joints.reserve(6);
  for (int i = 0; i < 6; ++i) {
    joints.push_back({.name = {static_cast<char>('a' + i)},
                      .axis = i == 0 || i == 4 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY(),
                      .lower = -3.1,
                      .upper = 3.1,
                      .velocity = 3,
                      .effort = 10});
  }
  std::vector<Eigen::Isometry3d> fixed(7, Eigen::Isometry3d::Identity());
  fixed[0].translation().z() = 0.1;
  fixed[1].translation().y() = 0.12;
  fixed[2].translation().z() = 0.4;
  fixed[3].translation().z() = 0.35;
  fixed[4].translation().y() = -0.1;
  fixed[5].translation().z() = 0.09;
  fixed[6].translation().y() = 0.08;
  return {"six joints", Chain(joints, fixed, "base", "hand")};
}

/// Arms that can take any pose: those made for tests, and the public ones where they are there.
inline std::vector<NamedArm> pose_arms() {
  std::vector<NamedArm> arms{seven_joint_arm(), six_joint_arm()};
  for (const ArmFile& file : shared_arm_files()) arms.push_back({file.path, load(file)});
  return arms;
}

/// A randomly generated arm: `joints` joints with axes and offsets in any direction, narrow and wide limits, and (if
/// `all_kinds`) some continuous and prismatic joints. The same seed gives the same arm.
inline Chain odd_arm(int joints, uint64_t seed, bool all_kinds = true) {
  const CounterRandom random(seed, static_cast<uint64_t>(joints));
  uint64_t counter = 0;
  const auto number = [&](double from, double to) { return random.uniform(counter++, from, to); };
  const auto direction = [&] {
    const double x = number(-1, 1), y = number(-1, 1), z = number(-1, 1);
    return (Eigen::Vector3d(x, y, z) + Eigen::Vector3d(0, 0, 1e-3)).normalized().eval();
  };
  std::vector<Joint> list;
  std::vector<Eigen::Isometry3d> fixed;
  for (int i = 0; i <= joints; ++i) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() = number(0.02, 0.4) * direction();
    X.linear() = Eigen::AngleAxisd(number(-3, 3), direction()).toRotationMatrix();
    fixed.push_back(X);
    if (i == joints) break;
    Joint joint{.name = {static_cast<char>('a' + i)}, .axis = direction(), .velocity = number(0.5, 4), .effort = 10};
    const double kind = all_kinds ? number(0, 1) : 0.5;
    if (kind < 0.15) {
      joint.type = Joint::Type::kContinuous;
    } else if (kind > 0.9) {
      joint.type = Joint::Type::kPrismatic;
      joint.lower = number(-0.3, 0);
      joint.upper = joint.lower + number(0.05, 0.4);
    } else {
      joint.lower = number(-3, 0.5);
      joint.upper = joint.lower + number(0.4, 5);
    }
    list.push_back(joint);
  }
  return Chain(list, fixed, "base", "hand");
}

/// The k-th posture of a seeded series, uniform inside the limits. `margin` is the fraction of the range left out at
/// each end.
inline JointVector random_posture(const Chain& chain, const CounterRandom& random, uint64_t k, double margin = 0) {
  JointVector theta(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    const double lower = chain.sample_lower(i), upper = chain.sample_upper(i), cut = margin * (upper - lower);
    theta[i] = random.uniform(k * kMaxJoints + static_cast<uint64_t>(i), lower + cut, upper - cut);
  }
  return theta;
}

}  // namespace multireach::testing
