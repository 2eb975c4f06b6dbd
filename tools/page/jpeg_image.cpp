#include "tools/page/jpeg_image.hpp"

#include <opencv2/imgproc.hpp>

#include "runtime/image_message.hpp"

namespace multireach {
namespace {

constexpr int kQuality = 75;

std::string as_string(const std::vector<uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

bool is_jpeg(const image_t& image) {
  return image.pixelformat == image_t::PIXEL_FORMAT_MJPEG && image.size > 3 && image.data[0] == 0xff &&
         image.data[1] == 0xd8;
}

std::string jpeg_of(const image_t& image, ImageCodec& codec, int width, bool smaller) {
  if (is_jpeg(image) && (!smaller || image.width <= width)) return as_string(image.data);
  cv::Mat bgr;
  if (!codec.decode(encoded(image), bgr)) return {};
  if (bgr.cols > width) {
    const double scale = static_cast<double>(width) / bgr.cols;
    cv::resize(bgr, bgr, {}, scale, scale, cv::INTER_AREA);
  }
  return as_string(codec.encode_jpeg(bgr, kQuality));
}

}  // namespace multireach
