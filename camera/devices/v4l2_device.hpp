#pragma once

#include <sys/types.h>

#include "camera/devices/camera_device.hpp"

namespace multireach {

/// The calls to the kernel that a V4L2 device needs, so that the conversation can be tested without one. They behave as
/// those of the same name: -1 and errno where they fail.
class DeviceCalls {
 public:
  virtual ~DeviceCalls() = default;
  virtual int open(const std::string& path) = 0;
  virtual int close(int file) = 0;
  virtual int ioctl(int file, unsigned long request, void* argument) = 0;
  virtual void* map(int file, size_t length, off_t offset) = 0;  ///< null where it fails
  virtual void unmap(void* memory, size_t length) = 0;
  /// Waits until the device has something to say; 0 when the time is over.
  virtual int wait(int file, int64_t timeout_us) = 0;
  virtual int64_t monotonic_us() = 0;
};
DeviceCalls& kernel_calls();

/// A V4L2 camera. Images are those of the camera, not decoded, with the driver's time of capture where it is on the
/// monotonic clock. Refused are a size or format other than asked; another rate, and controls that the device does not
/// have or accept, are remarked. `calls` must outlive the device.
OpenedDevice open_v4l2(DeviceCalls& calls, const std::string& path, const DeviceRequest& request);

}  // namespace multireach
