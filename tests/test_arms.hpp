#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "kinematics/random.hpp"
#include "kinematics/urdf_chain.hpp"

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

/// The public arms of ../shared/robots; empty where that folder is not.
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

/// The k-th posture of a seeded series, uniform inside the limits shrunk by `margin` of the range on each side.
inline JointVector random_posture(const Chain& chain, const CounterRandom& random, uint64_t k, double margin = 0) {
  JointVector theta(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    const double lower = chain.sample_lower(i), upper = chain.sample_upper(i), cut = margin * (upper - lower);
    theta[i] = random.uniform(k * kMaxJoints + static_cast<uint64_t>(i), lower + cut, upper - cut);
  }
  return theta;
}

}  // namespace multireach::testing
