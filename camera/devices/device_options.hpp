#pragma once

#include <optional>
#include <string>

#include "camera/devices/camera_device.hpp"

namespace multireach {

/// Which cameras to use, and their settings.
struct DeviceOptions {
  enum class Turn { kNone, kLeft, kRight, kBoth };

  std::string left{}, right{};  ///< device names, see `open_device`
  std::string side_by_side{};   ///< one device whose image contains left and right, side by side
  int width = 0, height = 0;    ///< of one image, pixels; 0: 640 x 480 for a device, any for a file or FIFO
  int64_t rate_hz = 30;
  DeviceRequest::Format format = DeviceRequest::Format::kAuto;
  std::optional<double> exposure_ms{}, white_balance_k{}, gain{};
  std::optional<double> lock_after_s{};  ///< time when those left automatic are locked; never if not given
  int jpeg_quality = 90;                 ///< for images that are not JPEG; 0 sends them raw
  std::optional<double> max_skew_ms{};   ///< largest time difference in a pair; default: half a frame period
  Turn rotate_180 = Turn::kNone;         ///< which cameras are mounted upside down

  /// Throws InputError unless there are two different cameras, or one side by side, with compatible settings.
  void check(const std::string& where) const;
};

/// Reads a device file (docs/cameras.md). Throws InputError that names file, line and key.
DeviceOptions load_device_options(const std::string& path);

/// The section of the reference page on a device file.
std::string device_config_reference();

}  // namespace multireach
