#pragma once

#include <string>
#include <vector>

#include "runtime/config.hpp"
#include "vision/stereo_vision.hpp"
#include "vision/tag_tracker.hpp"

namespace multireach {

/// A vision file: cameras and targets. It has section `cameras`, and either `targets` (a list, each with its `name`,
/// `colour` or `tag`, and the tracker's keys) or, for one target, the sections `colour` and `tracker`.
struct VisionConfig {
  struct Target {
    std::string name;
    vision::TrackerOptions options;  ///< including the rig
  };
  struct Tag {
    std::string name;
    vision::TagOptions options;  ///< including the rig
  };
  StereoRig rig;
  bool calibrated = true;       ///< whether the camera pose is known; without it, rig.X_WL is the identity
  std::vector<Target> targets;  ///< those that are found by their colours
  std::vector<Tag> tags;        ///< those that are AprilTags; at least one of both lists has an entry
  int64_t digest = 0;           ///< of the file, of the files that it names, and of the overrides

  /// Reads and checks a vision file. Throws InputError.
  static VisionConfig load(const std::string& path, const ConfigOverrides& overrides = {});
};

/// The sections of the reference page on a vision file and a colour file.
std::string vision_config_reference();

}  // namespace multireach
