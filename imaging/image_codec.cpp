#include "imaging/image_codec.hpp"

#include <turbojpeg.h>

#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "imaging/jpeg_decoder.hpp"

namespace multireach {
namespace {

/// Memory layout of a raw format, with OpenCV's type and conversion code.
struct Layout {
  int bytes_per_row, rows, type, to_bgr;
  bool even_width, even_height;  // required; even_height also marks formats that cannot be converted row by row
};

constexpr int kAsItIs = -1;  // no conversion

std::optional<Layout> layout_of(const EncodedImage& image) {
  const int w = image.width, h = image.height;
  switch (image.format) {
    case PixelFormat::kGray:
      return Layout{w, h, CV_8UC1, cv::COLOR_GRAY2BGR, false, false};
    case PixelFormat::kRgb:
      return Layout{3 * w, h, CV_8UC3, cv::COLOR_RGB2BGR, false, false};
    case PixelFormat::kBgr:
      return Layout{3 * w, h, CV_8UC3, kAsItIs, false, false};
    case PixelFormat::kYuyv:
      return Layout{2 * w, h, CV_8UC2, cv::COLOR_YUV2BGR_YUYV, true, false};
    case PixelFormat::kUyvy:
      return Layout{2 * w, h, CV_8UC2, cv::COLOR_YUV2BGR_UYVY, true, false};
    case PixelFormat::kI420:
      return Layout{w, h * 3 / 2, CV_8UC1, cv::COLOR_YUV2BGR_I420, true, true};
    case PixelFormat::kNv12:
      return Layout{w, h * 3 / 2, CV_8UC1, cv::COLOR_YUV2BGR_NV12, true, true};
    // OpenCV names a Bayer pattern after the second and third pixel of the second row.
    case PixelFormat::kBayerBggr:
      return Layout{w, h, CV_8UC1, cv::COLOR_BayerRG2BGR, true, true};
    case PixelFormat::kBayerGbrg:
      return Layout{w, h, CV_8UC1, cv::COLOR_BayerGR2BGR, true, true};
    case PixelFormat::kBayerGrbg:
      return Layout{w, h, CV_8UC1, cv::COLOR_BayerGB2BGR, true, true};
    case PixelFormat::kBayerRggb:
      return Layout{w, h, CV_8UC1, cv::COLOR_BayerBG2BGR, true, true};
    case PixelFormat::kMjpeg:
      break;
  }
  return std::nullopt;
}

}  // namespace

struct ImageCodec::Handles {
  tjhandle compress = tjInitCompress();
  ~Handles() {
    if (compress) tjDestroy(compress);
  }
};

ImageCodec::ImageCodec() : handles_(std::make_unique<Handles>()) {
  if (!handles_->compress) throw std::runtime_error("the JPEG library cannot be started");
}

ImageCodec::~ImageCodec() = default;

bool ImageCodec::decode(const EncodedImage& image, cv::Mat& bgr) {
  return decode(image, {0, 0, image.width, image.height}, bgr);
}

bool ImageCodec::decode(const EncodedImage& image, const cv::Rect& wanted, cv::Mat& bgr) {
  constexpr int kLargest = 16384;  // pixels on a side
  if (image.width < 2 || image.height < 2 || image.width > kLargest || image.height > kLargest) return false;
  const cv::Size size(image.width, image.height);
  const cv::Rect part = wanted & cv::Rect({}, size);
  if (part.empty()) return false;
  if (image.format == PixelFormat::kMjpeg) return decode_jpeg(image.data, size, part, bgr);
  const auto layout = layout_of(image);
  if (!layout || (layout->even_width && image.width % 2) || (layout->even_height && image.height % 2)) return false;
  const int stride = image.row_stride == 0 ? layout->bytes_per_row : image.row_stride;
  if (stride < layout->bytes_per_row) return false;
  const size_t needed = static_cast<size_t>(stride) * (layout->rows - 1) + layout->bytes_per_row;
  if (image.data.size() < needed) return false;
  if (stride != layout->bytes_per_row && layout->rows != image.height)
    return false;  // planar formats with padding are not defined
  const cv::Mat raw(layout->rows, image.width, layout->type, const_cast<uint8_t*>(image.data.data()),
                    static_cast<size_t>(stride));
  bgr.create(size, CV_8UC3);
  const cv::Range rows = layout->even_height ? cv::Range::all() : cv::Range(part.y, part.br().y);
  cv::Mat some = bgr.rowRange(rows);
  if (layout->to_bgr == kAsItIs) {
    raw.rowRange(rows).copyTo(some);
  } else {
    cv::cvtColor(raw.rowRange(rows), some, layout->to_bgr);
  }
  return true;
}

std::vector<uint8_t> ImageCodec::encode_jpeg(const cv::Mat& bgr, int quality) {
  unsigned char* jpeg = nullptr;
  unsigned long size = 0;
  if (tjCompress2(handles_->compress, bgr.data, bgr.cols, static_cast<int>(bgr.step), bgr.rows, TJPF_BGR, &jpeg, &size,
                  TJSAMP_420, quality, TJFLAG_ACCURATEDCT) != 0) {
    throw std::runtime_error(std::string("JPEG compression failed: ") + tjGetErrorStr2(handles_->compress));
  }
  std::vector<uint8_t> bytes(jpeg, jpeg + size);
  tjFree(jpeg);
  return bytes;
}

}  // namespace multireach
