#pragma once

#include <string>

#include "kinematics/chain.hpp"
#include "runtime/config.hpp"

namespace multireach {

/// The file of a robot: sections `robot` (which URDF, which chain), `controller`, `bridge`, `robot_sim`.
struct RobotConfig {
  Config file;
  std::string urdf_path;
  Chain chain;
  int64_t digest = 0;  ///< of both files' bytes

  /// Throws InputError for a missing or malformed file, key, URDF or link.
  static RobotConfig load(const std::string& path);
  /// How often the robot of section `robot_sim` says where it is, microseconds.
  int64_t state_period_us() const;
  /// An optional section of the file.
  std::optional<Config> section(const std::string& name) const;
};

/// The posture under `key`, one value per joint of the chain. Throws InputError when it is not inside the limits.
JointVector posture_from(const Config& config, const std::string& key, const Chain& chain);

}  // namespace multireach
