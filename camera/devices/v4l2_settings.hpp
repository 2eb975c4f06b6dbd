#pragma once

#include <linux/videodev2.h>

#include "camera/devices/v4l2_device.hpp"

namespace multireach {

/// An open V4L2 device during configuration; `name` appears in messages.
struct V4l2File {
  DeviceCalls& calls;
  int file;
  std::string name;

  /// Performs an ioctl; returns whether it succeeded, else errno says why not.
  bool ask(unsigned long request, void* argument) const { return calls.ioctl(file, request, argument) == 0; }
};

/// Sets size and format. Returns "" on success, else a sentence that names the sizes that the device has.
std::string set_format(const V4l2File& device, const DeviceRequest& request, v4l2_pix_format& given);
/// Set the frame rate and the controls. Return a sentence for each setting that the device did not accept.
std::vector<std::string> set_rate(const V4l2File& device, int64_t rate_hz);
std::vector<std::string> set_controls(const V4l2File& device, const DeviceRequest& request);
/// Switches remaining automatic controls to manual at their current values. Returns a sentence for each.
std::vector<std::string> lock_controls(const V4l2File& device, const DeviceRequest& request);

}  // namespace multireach
