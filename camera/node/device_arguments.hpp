#pragma once

#include "camera/devices/device_options.hpp"
#include "runtime/command_line.hpp"

namespace multireach {

/// Camera options of the command line; they override the device file.
struct DeviceArguments {
  std::string file;
  std::optional<std::string> left, right, side_by_side;
  std::optional<int> width, height, jpeg_quality;
  std::optional<int64_t> rate_hz;
  std::optional<double> max_skew_s;

  /// The options of the device file, overridden by the command line. Throws InputError.
  DeviceOptions options() const;
};

/// Adds the subcommand `device`, whose options fill `arguments`.
void add_device_command(CommandLine& cli, DeviceArguments& arguments);

}  // namespace multireach
