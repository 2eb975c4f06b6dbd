#include "camera/devices/v4l2_device.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "camera/devices/jpeg_stream.hpp"
#include "camera/devices/v4l2_settings.hpp"

namespace multireach {
namespace {

constexpr uint32_t kBuffers = 4;            // so that a late reader loses no image; each image has its own time stamp
constexpr int64_t kImageTimeout = 2000000;  // us; the device is reopened after this plus two periods without an image
constexpr int64_t kOldestStamp = 1000000;   // us; an older time stamp is from another clock

PixelFormat pixel_format_of(uint32_t code) {
  switch (code) {
    case V4L2_PIX_FMT_YUYV:
      return PixelFormat::kYuyv;
    case V4L2_PIX_FMT_UYVY:
      return PixelFormat::kUyvy;
    case V4L2_PIX_FMT_BGR24:
      return PixelFormat::kBgr;
    case V4L2_PIX_FMT_RGB24:
      return PixelFormat::kRgb;
    default:
      return PixelFormat::kMjpeg;
  }
}

class V4l2Device : public CameraDevice {
 public:
  explicit V4l2Device(V4l2File device) : device_(std::move(device)), last_buffer_us_(device_.calls.monotonic_us()) {}
  ~V4l2Device() override {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (streaming_) device_.ask(VIDIOC_STREAMOFF, &type);
    for (const Memory& memory : memory_) device_.calls.unmap(memory.start, memory.length);
    device_.calls.close(device_.file);
  }
  V4l2Device(const V4l2Device&) = delete;
  V4l2Device& operator=(const V4l2Device&) = delete;

  /// Returns a sentence on failure, "" on success; appends to `remarks`.
  std::string configure(const DeviceRequest& request, std::vector<std::string>& remarks) {
    v4l2_capability capability = {};
    if (!device_.ask(VIDIOC_QUERYCAP, &capability)) return "'" + device_.name + "': is not a camera device (V4L2)";
    const uint32_t can =
        capability.capabilities & V4L2_CAP_DEVICE_CAPS ? capability.device_caps : capability.capabilities;
    if (!(can & V4L2_CAP_VIDEO_CAPTURE) || !(can & V4L2_CAP_STREAMING)) {
      return "'" + device_.name + "': gives no images; of the device files of a camera, often only the first one does";
    }
    if (std::string fault = set_format(device_, request, format_); !fault.empty()) return fault;
    request_ = request;
    remarks = set_rate(device_, request.rate_hz);
    for (std::string& remark : set_controls(device_, request)) remarks.push_back(std::move(remark));
    return start();
  }

  std::vector<std::string> lock() override { return lock_controls(device_, request_); }

  Grab grab(int64_t timeout_us) override {
    const int ready = device_.calls.wait(device_.file, timeout_us);
    if (ready < 0) return {};
    v4l2_buffer buffer = empty_buffer();
    if (!device_.ask(VIDIOC_DQBUF, &buffer)) {
      if (errno == EAGAIN) return silent() ? gone("has given no image for two seconds") : Grab{};
      if (errno == EIO) return damaged("lost an image");
      return gone(errno == ENODEV ? "is gone" : std::string("gives no more images (") + std::strerror(errno) + ")");
    }
    last_buffer_us_ = device_.calls.monotonic_us();
    Grab grab = take(buffer);
    if (!device_.ask(VIDIOC_QBUF, &buffer)) return gone("is gone");
    return grab;
  }

 private:
  struct Memory {
    void* start;
    size_t length;
  };

  static Grab damaged(std::string reason) { return {.kind = Grab::Kind::kDamaged, .reason = std::move(reason)}; }
  static Grab gone(std::string reason) { return {.kind = Grab::Kind::kDisconnected, .reason = std::move(reason)}; }

  bool silent() const {
    return device_.calls.monotonic_us() - last_buffer_us_ > kImageTimeout + 2000000 / request_.rate_hz;
  }

  static v4l2_buffer empty_buffer() {
    v4l2_buffer buffer = {};
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    return buffer;
  }

  std::string start() {
    const auto fault = [this](const char* what) {
      return "'" + device_.name + "': " + what + " (" + std::strerror(errno) + ")";
    };
    v4l2_requestbuffers request = {};
    request.count = kBuffers;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (!device_.ask(VIDIOC_REQBUFS, &request) || request.count == 0)
      return fault("gives no memory for images; is it in use?");
    for (uint32_t index = 0; index < request.count; ++index) {
      v4l2_buffer buffer = empty_buffer();
      buffer.index = index;
      if (!device_.ask(VIDIOC_QUERYBUF, &buffer)) return fault("gives no memory for images");
      void* memory = device_.calls.map(device_.file, buffer.length, static_cast<off_t>(buffer.m.offset));
      if (!memory) return fault("its memory cannot be mapped");
      memory_.push_back({memory, buffer.length});
      if (!device_.ask(VIDIOC_QBUF, &buffer)) return fault("takes no memory for images");
    }
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (!device_.ask(VIDIOC_STREAMON, &type))
      return fault("does not start to give images; is the bus too slow for two cameras?");
    streaming_ = true;
    return "";
  }

  int64_t capture_time(const v4l2_buffer& buffer) const {
    if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return last_buffer_us_;
    const int64_t stamp = int64_t{buffer.timestamp.tv_sec} * 1000000 + buffer.timestamp.tv_usec;
    return stamp <= last_buffer_us_ && stamp > last_buffer_us_ - kOldestStamp ? stamp : last_buffer_us_;
  }

  Grab take(const v4l2_buffer& buffer) const {
    if (buffer.index >= memory_.size() || (buffer.flags & V4L2_BUF_FLAG_ERROR)) return damaged("lost an image");
    const Memory& memory = memory_[buffer.index];
    const auto* bytes = static_cast<const uint8_t*>(memory.start);
    Grab grab{.kind = Grab::Kind::kImage};
    RawImage& image = grab.image;
    image.monotonic_us = capture_time(buffer);
    image.format = pixel_format_of(format_.pixelformat);
    size_t size = std::min<size_t>(buffer.bytesused, memory.length);
    if (image.format == PixelFormat::kMjpeg) {
      const JpegExtent extent = jpeg_extent({bytes, size});
      if (extent.kind != JpegExtent::Kind::kWhole) return damaged("gave a JPEG image that is damaged");
      size = extent.bytes;  // some cameras append padding
      image.width = extent.width;
      image.height = extent.height;
    } else {
      image.width = static_cast<int>(format_.width);
      image.height = static_cast<int>(format_.height);
      image.row_stride = static_cast<int>(format_.bytesperline);
      if (size < size_t{format_.bytesperline} * format_.height) return damaged("gave an image that is cut off");
    }
    image.data.assign(bytes, bytes + size);
    return grab;
  }

  V4l2File device_;
  DeviceRequest request_;
  v4l2_pix_format format_ = {};
  std::vector<Memory> memory_;
  bool streaming_ = false;
  int64_t last_buffer_us_;
};

}  // namespace

OpenedDevice open_v4l2(DeviceCalls& calls, const std::string& path, const DeviceRequest& request) {
  const int file = calls.open(path);
  if (file < 0) return {.device = nullptr, .fault = "'" + path + "': cannot be opened (" + std::strerror(errno) + ")"};
  auto device = std::make_unique<V4l2Device>(V4l2File{calls, file, path});
  OpenedDevice opened;
  opened.fault = device->configure(request, opened.remarks);
  if (opened.fault.empty()) opened.device = std::move(device);
  return opened;
}

}  // namespace multireach
