#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>

namespace multireach {

/// The pixel formats of bot_core.images_t, with the same values (FourCC codes).
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

/// An image as received, not yet decoded.
struct EncodedImage {
  int width = 0, height = 0;  ///< pixels
  int row_stride = 0;         ///< bytes from one row to the next; 0: rows without padding
  PixelFormat format = PixelFormat::kBgr;
  std::span<const uint8_t> data;
};

/// Decodes and encodes images. Holds the JPEG library's state, so use one object per thread.
class ImageCodec {
 public:
  ImageCodec();
  ~ImageCodec();
  ImageCodec(const ImageCodec&) = delete;
  ImageCodec& operator=(const ImageCodec&) = delete;

  /// Decodes to 8-bit BGR; allocates `bgr` as needed. Returns false when the format is unknown, the data are too short
  /// for the size, the size is odd where the format requires an even one, or a JPEG is damaged or of another size than
  /// stated.
  [[nodiscard]] bool decode(const EncodedImage& image, cv::Mat& bgr);
  /// Decodes at least `part` of the image, in less time; those pixels are the same as when the whole image is decoded,
  /// the others are undefined. `part` is clipped to the image; returns false when it is empty then. Damage in a JPEG
  /// after the end of the part is not noticed.
  [[nodiscard]] bool decode(const EncodedImage& image, const cv::Rect& part, cv::Mat& bgr);
  /// Encodes an 8-bit BGR image as JPEG (4:2:0), `quality` 1 to 100.
  std::vector<uint8_t> encode_jpeg(const cv::Mat& bgr, int quality);

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace multireach
