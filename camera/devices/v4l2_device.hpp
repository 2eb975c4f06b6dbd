#pragma once

#include <sys/types.h>

#include "camera/devices/camera_device.hpp"

namespace multireach {

/// The system calls that a V4L2 device needs, as an interface so that they can be simulated in tests. They return -1
/// and set errno on failure, like the calls of the same name.
class DeviceCalls {
 public:
  virtual ~DeviceCalls() = default;
  virtual int open(const std::string& path) = 0;
  virtual int close(int file) = 0;
  virtual int ioctl(int file, unsigned long request, void* argument) = 0;
  virtual void* map(int file, size_t length, off_t offset) = 0;  ///< null on failure
  virtual void unmap(void* memory, size_t length) = 0;
  /// Waits until the device has data; 0 on timeout.
  virtual int wait(int file, int64_t timeout_us) = 0;
  virtual int64_t monotonic_us() = 0;
};
DeviceCalls& kernel_calls();

/// Opens a V4L2 camera. Images are delivered undecoded, stamped with the driver's time of capture if that is on the
/// monotonic clock. Fails when the device gives another size or format than requested; another frame rate, and controls
/// that the device lacks or refuses, only give remarks. `calls` must outlive the device.
OpenedDevice open_v4l2(DeviceCalls& calls, const std::string& path, const DeviceRequest& request);

}  // namespace multireach
