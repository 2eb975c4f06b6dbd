#include "camera/devices/stream_device.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "camera/devices/jpeg_stream.hpp"
#include "runtime/message_clock.hpp"

namespace multireach {
namespace {

constexpr int64_t kManyBytes = 8192;  // more than an AVI file has between images

int open_fifo(const std::string& path) {
  // Non-blocking: a blocking open would wait for a writer.
  return open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
}

class StreamDevice : public CameraDevice {
 public:
  StreamDevice(int file, std::string path) : file_(file), path_(std::move(path)) {}
  ~StreamDevice() override { close(file_); }
  StreamDevice(const StreamDevice&) = delete;
  StreamDevice& operator=(const StreamDevice&) = delete;

  Grab grab(int64_t timeout_us) override {
    const int64_t deadline = monotonic_us() + timeout_us;
    while (true) {
      if (auto image = stream_.next()) {
        bytes_without_image_ = 0;
        Grab grab{.kind = Grab::Kind::kImage};
        grab.image = {.monotonic_us = monotonic_us(),
                      .width = image->width,
                      .height = image->height,
                      .row_stride = 0,
                      .format = PixelFormat::kMjpeg,
                      .data = std::move(image->data)};
        return grab;
      }
      if (stream_.damaged() > damaged_reported_) {
        damaged_reported_ = stream_.damaged();
        return {.kind = Grab::Kind::kDamaged, .reason = "gave a JPEG image that is damaged"};
      }
      if (bytes_without_image_ > kManyBytes && stream_.pending() < 3) {
        bytes_without_image_ = 0;
        return {.kind = Grab::Kind::kDamaged, .reason = "gives something else than JPEG images"};
      }
      const int64_t left = deadline - monotonic_us();
      if (left <= 0) return {};
      const Grab::Kind kind = read_more(left);
      if (kind != Grab::Kind::kNoImage) return {.kind = kind, .reason = "is gone"};
    }
  }

 private:
  Grab::Kind read_more(int64_t timeout_us) {
    pollfd wait{file_, POLLIN, 0};
    if (poll(&wait, 1, static_cast<int>(timeout_us / 1000) + 1) <= 0) return Grab::Kind::kNoImage;
    const ssize_t size = read(file_, buffer_.data(), buffer_.size());
    if (size == 0) return wait_for_writer() ? Grab::Kind::kReconnecting : Grab::Kind::kDisconnected;
    if (size < 0) return errno == EAGAIN || errno == EINTR ? Grab::Kind::kNoImage : Grab::Kind::kDisconnected;
    bytes_without_image_ += size;
    stream_.put({buffer_.data(), static_cast<size_t>(size)});
    return Grab::Kind::kNoImage;
  }

  /// A FIFO whose writers have closed reports end of file until it is reopened. The new end is opened before the old
  /// one is closed, because the next writer may already be there and must never find the FIFO without a reader.
  bool wait_for_writer() {
    const int reopened = open_fifo(path_);
    if (reopened < 0) return false;
    close(file_);
    file_ = reopened;
    stream_ = JpegStream();
    damaged_reported_ = bytes_without_image_ = 0;
    return true;
  }

  int file_;
  std::string path_;
  std::array<uint8_t, 65536> buffer_{};
  JpegStream stream_;
  int64_t damaged_reported_ = 0;
  int64_t bytes_without_image_ = 0;
};

}  // namespace

OpenedDevice open_stream(const std::string& path) {
  const int file = open_fifo(path);
  if (file < 0) return {.device = nullptr, .fault = "'" + path + "': cannot be opened (" + std::strerror(errno) + ")"};
  return {.device = std::make_unique<StreamDevice>(file, path)};
}

}  // namespace multireach
