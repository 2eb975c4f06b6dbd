#include "tools/camera/file_sources.hpp"

#include <spdlog/spdlog.h>

#include <charconv>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "runtime/files.hpp"
#include "runtime/message_clock.hpp"
#include "vision/image_codec.hpp"

namespace multireach {
namespace {

Frame frame_of(vision::ImageCodec& codec, const cv::Mat& bgr, int64_t utime, int jpeg_quality) {
  Frame frame{.utime = utime,
              .width = bgr.cols,
              .height = bgr.rows,
              .row_stride = 0,
              .pixelformat = image_t::PIXEL_FORMAT_MJPEG,
              .data = {}};
  if (jpeg_quality > 0) {
    frame.data = codec.encode_jpeg(bgr, jpeg_quality);
    return frame;
  }
  const cv::Mat packed = bgr.isContinuous() ? bgr : bgr.clone();
  frame.pixelformat = image_t::PIXEL_FORMAT_BGR;
  frame.row_stride = static_cast<int>(packed.step);
  frame.data.assign(packed.data, packed.data + packed.total() * packed.elemSize());
  return frame;
}

class ImagesSource : public CameraSource {
 public:
  explicit ImagesSource(const ImagesOptions& options)
      : options_(options),
        left_(matching_files("--left", options.left)),
        right_(matching_files("--right", options.right)) {
    if (left_.size() != right_.size()) {
      throw InputError("--left has " + std::to_string(left_.size()) + " files and --right " +
                       std::to_string(right_.size()) + "; they must be pairs");
    }
    load(left_[0], 0);
    load(right_[0], 0);
  }

  std::optional<StereoPair> next() override {
    const auto count = static_cast<int64_t>(left_.size());
    if (number_ >= count * options_.repeat) return std::nullopt;
    const auto at = static_cast<size_t>(number_ % count);
    StereoPair pair;
    pair.utime = next_utime();
    pair.left = load(left_[at], pair.utime);
    pair.right = load(right_[at], pair.utime);
    ++number_;
    return pair;
  }
  int64_t next_utime() const override { return options_.origin_utime + number_ * 1000000 / options_.rate_hz; }
  int64_t period_us() const override { return 1000000 / options_.rate_hz; }

 private:
  Frame load(const std::string& path, int64_t utime) {
    std::vector<uint8_t> bytes = read_binary_file(path);
    cv::Mat image;
    if (!bytes.empty()) image = cv::imdecode(bytes, cv::IMREAD_COLOR);
    if (image.empty()) throw InputError(path + ": is not an image that can be read");
    const bool jpeg = bytes.size() > 2 && bytes[0] == 0xff && bytes[1] == 0xd8;
    if (!jpeg) return frame_of(codec_, image, utime, options_.jpeg_quality);
    return {.utime = utime,
            .width = image.cols,
            .height = image.rows,
            .row_stride = 0,
            .pixelformat = image_t::PIXEL_FORMAT_MJPEG,
            .data = std::move(bytes)};
  }

  ImagesOptions options_;
  std::vector<std::string> left_, right_;
  vision::ImageCodec codec_;
  int64_t number_ = 0;
};

class DeviceSource : public CameraSource {
 public:
  explicit DeviceSource(const DeviceOptions& options) : options_(options), next_utime_(wall_us()) {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // what goes wrong is said once, below
    if (!options.side_by_side.empty()) {
      open(left_, options.side_by_side, 2 * options.width);
    } else {
      open(left_, options.left, options.width);
      open(right_, options.right, options.width);
    }
  }

  std::optional<StereoPair> next() override {
    StereoPair pair;
    next_utime_ += period_us();
    const bool two = right_.isOpened();
    if (!left_.grab()) return ended();
    const int64_t left_utime = wall_us();
    if (two && !right_.grab()) return ended();
    const int64_t right_utime = two ? wall_us() : left_utime;
    cv::Mat left, right;
    if (!left_.retrieve(left) || (two && !right_.retrieve(right))) return ended();
    if (!two) {
      const int half = left.cols / 2;
      right = left.colRange(half, 2 * half);
      left = left.colRange(0, half);
    }
    pair.utime = left_utime;
    pair.left = frame_of(codec_, left, left_utime, options_.jpeg_quality);
    pair.right = frame_of(codec_, right, right_utime, options_.jpeg_quality);
    return pair;
  }
  int64_t next_utime() const override { return next_utime_; }
  int64_t period_us() const override { return 1000000 / options_.rate_hz; }

 private:
  void open(cv::VideoCapture& capture, const std::string& name, int width) const {
    int index = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
    const bool number = error == std::errc() && end == name.data() + name.size();
    if (!(number ? capture.open(index, cv::CAP_V4L2) : capture.open(name))) {
      throw InputError("'" + name + "': is neither a camera device nor a video that can be opened");
    }
    capture.set(cv::CAP_PROP_FRAME_WIDTH, width);
    capture.set(cv::CAP_PROP_FRAME_HEIGHT, options_.height);
    capture.set(cv::CAP_PROP_FPS, static_cast<double>(options_.rate_hz));
  }

  static std::optional<StereoPair> ended() {
    spdlog::warn("the camera gives no more images");
    return std::nullopt;
  }

  DeviceOptions options_;
  cv::VideoCapture left_, right_;
  vision::ImageCodec codec_;
  int64_t next_utime_;
};

}  // namespace

std::unique_ptr<CameraSource> make_images_source(const ImagesOptions& options) {
  return std::make_unique<ImagesSource>(options);
}
std::unique_ptr<CameraSource> make_device_source(const DeviceOptions& options) {
  return std::make_unique<DeviceSource>(options);
}

}  // namespace multireach
