#include "tools/videos/video_source.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/videoio.hpp>

#include "runtime/files.hpp"
#include "tools/log/import/image_store.hpp"

namespace multireach {
namespace {

constexpr double kLargestRate = 1e4;

/// A video, read forwards.
class Video {
 public:
  explicit Video(std::string path) : path_(std::move(path)) { open(); }

  const std::string& path() const { return path_; }
  double rate_hz() const { return capture_.get(cv::CAP_PROP_FPS); }
  /// The number of images that can be read: files may state another one.
  size_t count(const std::function<void(double)>& progress) {
    const double stated = std::max(1.0, capture_.get(cv::CAP_PROP_FRAME_COUNT));
    size_t number = 0;
    while (capture_.grab()) progress(std::min(1.0, static_cast<double>(++number) / stated));
    open();
    return number;
  }
  /// Image `number`, which is not before the one read last.
  const cv::Mat& read(size_t number) {
    for (; next_ <= number; ++next_) {
      if (!capture_.grab()) throw InputError(fmt::format("{}: image {} cannot be read", path_, next_));
    }
    if (!capture_.retrieve(bgr_) || bgr_.type() != CV_8UC3)
      throw InputError(fmt::format("{}: image {} is damaged, or not in colour", path_, number));
    return bgr_;
  }

 private:
  void open() {
    next_ = 0;
    if (!capture_.open(path_)) throw InputError(path_ + ": is not a video that can be opened");
  }

  std::string path_;
  cv::VideoCapture capture_;
  cv::Mat bgr_;
  size_t next_ = 0;
};

class VideoSource : public ImageSource {
 public:
  explicit VideoSource(const VideoOptions& options)
      : options_(options), videos_{Video(options.left), Video(options.right)}, store_(options.jpeg_quality) {
    for (const Video& video : videos_) {
      const double rate = options.rate_hz.value_or(video.rate_hz());
      if (!(rate > 0 && rate < kLargestRate))
        throw InputError(fmt::format("{}: does not say its rate; expected --rate", video.path()));
    }
    constexpr double kSameRate = 1e-3;
    const double left = videos_[0].rate_hz(), right = videos_[1].rate_hz();
    if (!options.rate_hz && std::abs(left - right) > kSameRate * left)
      throw InputError(
          fmt::format("{}: {:.3f} images per second, but {} has {:.3f}; expected videos of one rate, or --rate",
                      options.right, right, options.left, left));
    rate_hz_ = options.rate_hz.value_or(left);
  }

  std::vector<ListedImage> list(const Progress& progress) override {
    std::vector<ListedImage> images;
    for (const Side side : {Side::kLeft, Side::kRight}) {
      const double before = 0.5 * static_cast<double>(index(side));
      const size_t count = videos_[index(side)].count([&](double part) { progress(before + 0.5 * part); });
      for (size_t k = 0; k < count; ++k)
        images.push_back(
            {options_.origin_utime + static_cast<int64_t>(std::llround(1e6 * static_cast<double>(k) / rate_hz_)), side,
             k});
    }
    return images;
  }
  Frame read(const ListedImage& image) override {
    Video& video = videos_[index(image.side)];
    const cv::Mat& bgr = video.read(image.number);
    const EncodedImage pixels{.width = bgr.cols,
                              .height = bgr.rows,
                              .row_stride = static_cast<int>(bgr.step),
                              .format = PixelFormat::kBgr,
                              .data = {bgr.data, bgr.step * static_cast<size_t>(bgr.rows)}};
    return store_.raw_frame(pixels, fmt::format("{}: image {}", video.path(), image.number), image.utime);
  }

 private:
  VideoOptions options_;
  std::array<Video, 2> videos_;
  ImageStore store_;
  double rate_hz_ = 0;
};

}  // namespace

std::unique_ptr<ImageSource> open_videos(const VideoOptions& options) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // errors are reported once, here
  return std::make_unique<VideoSource>(options);
}

}  // namespace multireach
