#pragma once

#include <string>
#include <vector>

#include "vision/stereo_tracker.hpp"

namespace multireach {

/// What vision looks for, and with which cameras, from a vision file: section `cameras`, and either `targets` (a list,
/// each with its `name`, `colour` and tracker's keys) or, for one target, the sections `colour` and `tracker`.
struct VisionConfig {
  struct Target {
    std::string name;
    vision::TrackerOptions options;  ///< with the rig
  };
  StereoRig rig;
  std::vector<Target> targets;
  int64_t digest = 0;  ///< of the bytes of the file and of those that it names

  /// Throws InputError.
  static VisionConfig load(const std::string& path);
};

}  // namespace multireach
