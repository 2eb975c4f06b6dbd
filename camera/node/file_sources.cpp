#include "camera/node/file_sources.hpp"

#include "camera/devices/frame_converter.hpp"
#include "runtime/files.hpp"
#include "runtime/image_file.hpp"

namespace multireach {
namespace {

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
    const cv::Mat image = decode_image(bytes, path);
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
  ImageCodec codec_;
  int64_t number_ = 0;
};

}  // namespace

std::unique_ptr<CameraSource> make_images_source(const ImagesOptions& options) {
  return std::make_unique<ImagesSource>(options);
}

}  // namespace multireach
