#pragma once

#include <thread>

#include "camera/devices/camera_device.hpp"
#include "camera/devices/capture_clock.hpp"
#include "camera/devices/frame_maker.hpp"
#include "camera/pairing/stereo_buffer.hpp"

namespace multireach {

/// One camera and its thread: grabs images, stamps and forms them, and puts them into the buffer. A device that is gone
/// is opened again, every half second, until it is there.
class CaptureThread {
 public:
  struct Camera {
    std::string name{};  ///< of the device
    Side side = Side::kLeft;
    bool both = false;  ///< it gives both sides
    DeviceRequest request{};
    FrameForm form{};
  };

  /// Opens the device and starts. Throws InputError when it cannot be opened now. `buffer` must outlive it.
  CaptureThread(const Camera& camera, const CaptureClock& clock, StereoBuffer& buffer);

 private:
  void run(const std::stop_token& stop);
  void reopen(const std::stop_token& stop);
  void deliver(RawImage image);
  void grab();
  void lose_image(const std::string& damage);
  void set_trouble(const std::string& trouble);
  void lock_when_due();
  std::vector<Side> sides() const;
  std::string who() const;

  Camera camera_;
  CaptureClock clock_;
  StereoBuffer& buffer_;
  FrameMaker maker_;
  std::unique_ptr<CameraDevice> device_;
  int64_t opened_us_;
  bool locked_ = false, ended_ = false;
  int64_t image_us_;           // when the last good image came
  int64_t complained_us_ = 0;  // when the log last heard of a lost image
  std::string damage_;         // what was wrong with the newest images, if they were not good
  std::string trouble_;        // what NODE_STATUS says is wrong
  std::jthread thread_;        // last: it uses all the others
};

}  // namespace multireach
