#pragma once

#include <linux/videodev2.h>

#include "camera/devices/v4l2_device.hpp"

namespace multireach {

/// An open V4L2 device while it is asked for what the user wants. `name` stands in the sentences.
struct V4l2File {
  DeviceCalls& calls;
  int file;
  std::string name;

  /// Whether the device did it; errno says why not.
  bool ask(unsigned long request, void* argument) const { return calls.ioctl(file, request, argument) == 0; }
};

/// Sets size and format. Returns a sentence when the device does not give what was asked for, which names what it has.
std::string set_format(const V4l2File& device, const DeviceRequest& request, v4l2_pix_format& given);
/// Sets the rate and the controls. Returns a sentence for each that the device did not accept.
std::vector<std::string> set_rate(const V4l2File& device, int64_t rate_hz);
std::vector<std::string> set_controls(const V4l2File& device, const DeviceRequest& request);
/// Switches off what the camera still chooses by itself, at the values that it has now. Returns a sentence for each.
std::vector<std::string> lock_controls(const V4l2File& device, const DeviceRequest& request);

}  // namespace multireach
