#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "runtime/camera_files.hpp"

namespace multireach {

/// Where a calibration of two cameras goes, and as what: -o, once or twice, and --format.
struct CameraOutput {
  std::vector<std::string> paths;
  std::string word;  ///< of --format; "" for what the names say

  void add_options(CLI::App& app);
  CameraFormat format() const;
  /// Before the work: throws InputError when the number of names is not that of the format's files, or one cannot be
  /// written.
  void check() const;
  void write(const StereoRig& rig, bool robot) const;
};

/// Throws InputError when a file of this name cannot be written; "" is none.
void check_writable(const std::string& path);

/// "9x6" as two whole numbers from `min` to `max`; throws InputError that names `option`.
std::pair<int, int> parse_size(const std::string& option, const std::string& text, int min, int max);

}  // namespace multireach
