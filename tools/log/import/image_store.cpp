#include "tools/log/import/image_store.hpp"

#include <fmt/format.h>

#include "imaging/jpeg_decoder.hpp"
#include "runtime/files.hpp"
#include "runtime/image_file.hpp"

namespace multireach {

Frame ImageStore::file_frame(std::vector<uint8_t> bytes, const std::string& name, int64_t utime) {
  if (const auto size = jpeg_size(bytes)) {
    return {.utime = utime,
            .width = size->width,
            .height = size->height,
            .row_stride = 0,
            .pixelformat = static_cast<int32_t>(PixelFormat::kMjpeg),
            .data = std::move(bytes)};
  }
  return frame_of(codec_, decode_image(bytes, name), utime, jpeg_quality_);
}

Frame ImageStore::raw_frame(const EncodedImage& image, const std::string& name, int64_t utime) {
  cv::Mat bgr;
  if (!codec_.decode(image, bgr)) {
    throw InputError(fmt::format(
        "{}: an image of {} x {} pixels with {} bytes in rows of {} cannot be decoded; expected 2 to 16384 pixels on a "
        "side (even numbers in YUV and Bayer formats), and a row for each line",
        name, image.width, image.height, image.data.size(), image.row_stride));
  }
  if (jpeg_quality_ > 0) return frame_of(codec_, bgr, utime, jpeg_quality_);
  return {.utime = utime,
          .width = image.width,
          .height = image.height,
          .row_stride = image.row_stride,
          .pixelformat = static_cast<int32_t>(image.format),
          .data = {image.data.begin(), image.data.end()}};
}

}  // namespace multireach
