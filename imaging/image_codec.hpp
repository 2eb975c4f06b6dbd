#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>

namespace multireach {

/// The pixel formats of bot_core.images_t; the values are its own (FourCC codes).
enum class PixelFormat : int32_t {
  kGray = 1497715271,
  kRgb = 859981650,
  kBgr = 861030210,
  kYuyv = 1448695129,
  kUyvy = 1498831189,
  kI420 = 808596553,
  kNv12 = 842094158,
  kMjpeg = 1196444237,
  kBayerBggr = 825770306,
  kBayerGbrg = 844650584,
  kBayerGrbg = 861427800,
  kBayerRggb = 878205016,
};

/// An image as it came, not yet decoded.
struct EncodedImage {
  int width = 0, height = 0;  ///< pixels
  int row_stride = 0;         ///< bytes from one row to the next; 0 means rows without padding
  PixelFormat format = PixelFormat::kBgr;
  std::span<const uint8_t> data;
};

/// Decodes and encodes images. Holds the JPEG library's state, so each thread has its own.
class ImageCodec {
 public:
  ImageCodec();
  ~ImageCodec();
  ImageCodec(const ImageCodec&) = delete;
  ImageCodec& operator=(const ImageCodec&) = delete;

  /// Decodes into 8-bit BGR. Returns false when the format is not known, the data are too short for the size, the size
  /// is odd where the format needs it even, or a JPEG is damaged or of another size than stated. `bgr` is made to fit.
  bool decode(const EncodedImage& image, cv::Mat& bgr);
  /// The same for a part of the image, in less time: at least the part's pixels are as if the whole were decoded, the
  /// others are undefined. What of the part is outside of the image is ignored; returns false when nothing is left of
  /// it, and for a JPEG only when it is damaged before the end of the part.
  bool decode(const EncodedImage& image, const cv::Rect& part, cv::Mat& bgr);
  /// A JPEG (4:2:0) of an 8-bit BGR image, `quality` 1 to 100.
  std::vector<uint8_t> encode_jpeg(const cv::Mat& bgr, int quality);

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace multireach
