#include "camera/devices/video_file_device.hpp"

#include <algorithm>
#include <chrono>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/videoio.hpp>
#include <thread>

#include "runtime/message_clock.hpp"

namespace multireach {
namespace {

class VideoFileDevice : public CameraDevice {
 public:
  VideoFileDevice(cv::VideoCapture capture, const DeviceRequest& request)
      : capture_(std::move(capture)), start_us_(request.start_us), rate_hz_(request.rate_hz) {}

  Grab grab(int64_t timeout_us) override {
    const int64_t due = start_us_ + number_ * 1000000 / rate_hz_;
    const int64_t wait = due - monotonic_us();
    if (wait > 0) std::this_thread::sleep_for(std::chrono::microseconds(std::min(wait, timeout_us)));
    if (wait > timeout_us) return {};
    if (!capture_.read(bgr_) || bgr_.empty()) return {.kind = Grab::Kind::kEndOfStream};
    ++number_;
    if (bgr_.type() != CV_8UC3) return {.kind = Grab::Kind::kDamaged, .reason = "gave an image that is not in colour"};
    Grab grab{.kind = Grab::Kind::kImage};
    const cv::Mat packed = bgr_.isContinuous() ? bgr_ : bgr_.clone();
    grab.image = {.monotonic_us = due,
                  .width = packed.cols,
                  .height = packed.rows,
                  .row_stride = static_cast<int>(packed.step),
                  .format = PixelFormat::kBgr,
                  .data = {packed.data, packed.data + packed.total() * packed.elemSize()}};
    return grab;
  }
  bool waits_for_reader() const override { return true; }

 private:
  cv::VideoCapture capture_;
  int64_t start_us_, rate_hz_;
  int64_t number_ = 0;
  cv::Mat bgr_;
};

}  // namespace

OpenedDevice open_video_file(const std::string& path, const DeviceRequest& request) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // errors are reported once, below
  cv::VideoCapture capture(path);
  if (!capture.isOpened()) {
    return {.device = nullptr, .fault = "'" + path + "': is neither a camera device nor a video that can be opened"};
  }
  const int width = static_cast<int>(capture.get(cv::CAP_PROP_FRAME_WIDTH));
  const int height = static_cast<int>(capture.get(cv::CAP_PROP_FRAME_HEIGHT));
  if ((request.width > 0 && width != request.width) || (request.height > 0 && height != request.height)) {
    return {.device = nullptr,
            .fault = "'" + path + "': has images of " + std::to_string(width) + " x " + std::to_string(height) +
                     " pixels, not " + std::to_string(request.width) + " x " + std::to_string(request.height) +
                     " as asked"};
  }
  return {.device = std::make_unique<VideoFileDevice>(std::move(capture), request)};
}

}  // namespace multireach
