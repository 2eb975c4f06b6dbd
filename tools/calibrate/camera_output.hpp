#pragma once

#include <string>
#include <utility>
#include <vector>

#include "runtime/camera_files.hpp"
#include "runtime/command_line.hpp"

namespace multireach {

/// Output files and format of a stereo calibration: options -o (once or twice) and --format.
struct CameraOutput {
  std::vector<std::string> paths;
  std::string word;  ///< value of --format; "" to choose by file name

  void add_options(CommandLine& app);
  CameraFormat format() const;
  /// Call before calibrating: throws InputError when the number of names does not fit the format, or a file cannot be
  /// written.
  void check() const;
  void write(const StereoRig& rig, bool robot) const;
};

/// Throws InputError when `path` cannot be written; "" means no file and passes.
void check_writable(const std::string& path);

/// "9x6" as two whole numbers from `min` to `max`; throws InputError that names `option`.
std::pair<int, int> parse_size(const std::string& option, const std::string& text, int min, int max);

}  // namespace multireach
