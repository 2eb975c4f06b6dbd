#pragma once

#include <map>
#include <string>
#include <vector>

#include "kinematics/chain.hpp"
#include "runtime/config.hpp"

namespace multireach {

/// A robot.yaml file: the section `robot` (URDF and kinematic chain), values shared by several processes (`tick_ms`,
/// `state_hz`), and one section for each process: `controller`, `bridge`, `robot_sim`.
struct RobotConfig {
  Config file;
  std::string urdf_path;
  Chain chain;
  JointVector joint_acceleration_limits{};  ///< rad/s^2 (m/s^2); empty where none are given
  JointVector joint_jerk_limits{};          ///< rad/s^3 (m/s^3); empty where none are given
  int64_t digest = 0;                       ///< of both files' bytes, and of the overrides
  int64_t tick_us = 50000;                  ///< period of the controller's set-points (`tick_ms`)
  int64_t state_period_us = 0;              ///< period of the simulated robot's ROBOT_STATE (`state_hz`)
  std::map<std::string, double> start{};    ///< joint positions from which a simulated robot starts, rad or m

  /// Reads a robot.yaml, or the one in a folder. Throws InputError for a missing or malformed file, key, URDF or link.
  static RobotConfig load(const std::string& file_or_folder, const ConfigOverrides& overrides = {});
  /// An optional section of the file.
  std::optional<Config> section(const std::string& name) const;
};

/// Sentences on what is allowed but most likely wrong: a tip above the base in the URDF's tree; limits of rotary joints
/// that look like degrees (beyond four turns, faster than 30 rad/s, or an acceleration that reaches the velocity limit
/// within 5 ms).
std::vector<std::string> doubts_about(const RobotConfig& robot);

/// The joint configuration under `key`, one value per joint of the chain. Throws InputError when it is outside the
/// limits.
JointVector joint_configuration_from(const Config& config, const std::string& key, const Chain& chain);

/// The reference page's sections on what several processes read in a robot.yaml.
std::string robot_config_reference();

}  // namespace multireach
