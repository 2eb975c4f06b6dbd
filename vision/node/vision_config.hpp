#pragma once

#include <string>
#include <vector>

#include "vision/stereo_vision.hpp"

namespace multireach {

/// A vision file: cameras and targets. It has section `cameras`, and either `targets` (a list, each with its `name`,
/// `colour` and the tracker's keys) or, for one target, the sections `colour` and `tracker`.
struct VisionConfig {
  struct Target {
    std::string name;
    vision::TrackerOptions options;  ///< including the rig
  };
  StereoRig rig;
  std::vector<Target> targets;
  int64_t digest = 0;  ///< of the file and of the files that it names

  /// Reads and checks a vision file. Throws InputError.
  static VisionConfig load(const std::string& path);
};

/// The sections of the reference page on a vision file and a colour file.
std::string vision_config_reference();

}  // namespace multireach
