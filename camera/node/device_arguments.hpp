#pragma once

#include <CLI/CLI.hpp>

#include "camera/devices/device_options.hpp"

namespace multireach {

/// What the command line says about cameras; it goes before what the file says.
struct DeviceArguments {
  std::string file;
  std::optional<std::string> left, right, side_by_side;
  std::optional<int> width, height, jpeg_quality;
  std::optional<int64_t> rate_hz;
  std::optional<double> max_skew_ms;

  /// File and command line together. Throws InputError.
  DeviceOptions options() const;
};

/// Adds the subcommand `device` with its options, which fill `arguments`.
CLI::App* add_device_command(CLI::App& cli, DeviceArguments& arguments);

}  // namespace multireach
