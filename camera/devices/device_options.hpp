#pragma once

#include <optional>
#include <string>

#include "camera/devices/camera_device.hpp"

namespace multireach {

/// Which cameras, and what they are asked for.
struct DeviceOptions {
  enum class Turn { kNone, kLeft, kRight, kBoth };

  std::string left{}, right{};  ///< as `open_device` takes them
  std::string side_by_side{};   ///< one device whose image holds left and right beside each other
  int width = 0, height = 0;    ///< of one image, pixels; 0: 640 x 480 from a device, any from a file or a FIFO
  int64_t rate_hz = 30;
  DeviceRequest::Format format = DeviceRequest::Format::kAuto;
  std::optional<double> exposure_ms{}, white_balance_k{}, gain{};
  std::optional<double> lock_after_s{};  ///< what of these is not given is locked then; never when not given either
  int jpeg_quality = 90;                 ///< of images that do not come as JPEG; 0 sends them raw
  std::optional<double> max_skew_ms{};   ///< between the two images of a pair; half a period when not given
  Turn rotate_180 = Turn::kNone;         ///< images of cameras that are mounted upside down

  /// Throws InputError when the cameras are not two different ones, or one side by side, or what is asked of them does
  /// not fit together.
  void check(const std::string& where) const;
};

/// Reads a device file, see docs/cameras.md. Throws InputError that names file, line and key.
DeviceOptions load_device_options(const std::string& path);

}  // namespace multireach
