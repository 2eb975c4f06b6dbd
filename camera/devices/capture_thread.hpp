#pragma once

#include <functional>
#include <thread>

#include "camera/devices/camera_device.hpp"
#include "camera/devices/capture_clock.hpp"
#include "camera/devices/frame_converter.hpp"
#include "camera/pairing/stereo_buffer.hpp"

namespace multireach {

/// One camera and its thread: grabs images, stamps and converts them, and puts them into the buffer. A device that
/// disappears is reopened, with an attempt every half second. An exception in the thread becomes the buffer's failure.
class CaptureThread {
 public:
  struct Camera {
    std::string name{};  ///< device name
    Side side = Side::kLeft;
    bool both = false;  ///< the device gives both images
    DeviceRequest request{};
    FrameConversion form{};
    std::function<OpenedDevice(const std::string&, const DeviceRequest&)> open = open_device;
  };

  /// Opens the device and starts the thread. Throws InputError when the device cannot be opened. `buffer` must outlive
  /// this object.
  CaptureThread(const Camera& camera, const CaptureClock& clock, StereoBuffer& buffer);

 private:
  void run(const std::stop_token& stop);
  void reopen(const std::stop_token& stop);
  void deliver(RawImage image);
  void grab();
  void report_lost_image(const std::string& damage);
  void set_fault(const std::string& fault);
  void lock_when_due();
  std::vector<Side> sides() const;
  std::string label() const;

  Camera camera_;
  CaptureClock clock_;
  StereoBuffer& buffer_;
  FrameConverter converter_;
  std::unique_ptr<CameraDevice> device_;
  int64_t opened_us_;
  bool locked_ = false, ended_ = false;
  int64_t image_us_;             // time of the last good image
  int64_t last_warning_us_ = 0;  // time of the last log entry about a lost image
  std::string damage_;           // fault of the newest images, if any
  std::string fault_;            // fault shown in NODE_STATUS
  std::jthread thread_;          // last member: the thread uses all the others
};

}  // namespace multireach
