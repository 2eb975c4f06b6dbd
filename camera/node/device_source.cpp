#include "camera/node/device_source.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "camera/devices/capture_thread.hpp"

namespace multireach {
namespace {

constexpr int64_t kMaxWait = 50000;      // us; the node must also handle messages while no images arrive
constexpr int64_t kFilesBegin = 100000;  // us after the start; both are open by then

/// Whether images come from a video file.
bool is_recording(const DeviceOptions& options) {
  std::error_code error;
  const std::array names{options.left, options.right, options.side_by_side};
  return std::ranges::any_of(names,
                             [&](const std::string& name) { return std::filesystem::is_regular_file(name, error); });
}

FramePairing pairing_for(const DeviceOptions& options) {
  const int64_t period = 1000000 / options.rate_hz;
  const int64_t half = period / 2;
  return {period, options.max_skew_ms ? static_cast<int64_t>(std::lround(*options.max_skew_ms * 1000)) : half};
}

class DeviceSource : public CameraSource {
 public:
  explicit DeviceSource(const DeviceOptions& options)
      : period_us_(1000000 / options.rate_hz), buffer_(pairing_for(options)) {
    using Turn = DeviceOptions::Turn;
    const bool both = !options.side_by_side.empty();
    const int64_t start_us = monotonic_us() + kFilesBegin;
    if (is_recording(options)) clock_ = CaptureClock::of_recording(start_us);
    const auto add = [&](const std::string& name, Side side, Turn turn) {
      CaptureThread::Camera camera{.name = name, .side = side, .both = both};
      camera.request = {.width = options.width * (both ? 2 : 1),
                        .height = options.height,
                        .rate_hz = options.rate_hz,
                        .format = options.format,
                        .exposure_ms = options.exposure_ms,
                        .white_balance_k = options.white_balance_k,
                        .gain = options.gain,
                        .lock_after_s = options.lock_after_s,
                        .start_us = start_us};
      camera.form = {.width = camera.request.width,
                     .height = camera.request.height,
                     .jpeg_quality = options.jpeg_quality,
                     .side_by_side = both,
                     .rotate_180 = options.rotate_180 == Turn::kBoth || options.rotate_180 == turn};
      threads_.push_back(std::make_unique<CaptureThread>(camera, clock_, buffer_));
    };
    if (both) {
      add(options.side_by_side, Side::kLeft, Turn::kBoth);
    } else {
      add(options.left, Side::kLeft, Turn::kLeft);
      add(options.right, Side::kRight, Turn::kRight);
    }
  }

  std::optional<StereoPair> next() override {
    auto frames = buffer_.pop(kMaxWait);
    if (!frames) return std::nullopt;
    StereoPair pair;
    pair.utime = frames->left.utime;
    pair.left = std::move(frames->left);
    pair.right = std::move(frames->right);
    return pair;
  }
  bool waiting() const override { return !buffer_.ended(); }
  /// Always now: `next` waits for the cameras and so sets the pace.
  int64_t next_utime() const override { return clock_.now(); }
  int64_t period_us() const override { return period_us_; }
  std::string state() const override { return buffer_.state(clock_.now()); }

 private:
  int64_t period_us_;
  CaptureClock clock_;
  StereoBuffer buffer_;
  std::vector<std::unique_ptr<CaptureThread>> threads_;  // destroyed first: the threads use the buffer
};

}  // namespace

std::unique_ptr<CameraSource> make_device_source(const DeviceOptions& options) {
  return std::make_unique<DeviceSource>(options);
}

}  // namespace multireach
