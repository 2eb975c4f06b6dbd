#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace multireach {

/// The extent and size of a JPEG image, found from its markers (ITU T.81, annex B) without decoding it.
struct JpegExtent {
  enum class Kind {
    kWhole,       ///< from SOI to EOI, with a frame header and a scan
    kIncomplete,  ///< valid so far; the end is missing
    kBroken,      ///< not a valid JPEG image
  };
  Kind kind = Kind::kBroken;
  size_t bytes = 0;           ///< whole: from SOI to EOI; else the length of the valid part
  int width = 0, height = 0;  ///< pixels; 0 before the frame header
};
JpegExtent jpeg_extent(std::span<const uint8_t> bytes);

/// Extracts JPEG images from a stream of bytes. Bytes between them are skipped, so a plain sequence of JPEGs, an AVI
/// with MJPG and the multipart stream of a network camera all work, even from the middle of the stream.
class JpegStream {
 public:
  struct Image {
    int width = 0, height = 0;
    std::vector<uint8_t> data;
  };

  void put(std::span<const uint8_t> bytes);
  /// The next whole image, or nothing when more bytes are needed.
  std::optional<Image> next();
  /// Number of images that were damaged, or cut off by the next one, since the start.
  int64_t damaged() const { return damaged_; }
  /// Number of buffered bytes of an incomplete image.
  size_t pending() const { return bytes_.size(); }

 private:
  std::vector<uint8_t> bytes_;
  int64_t damaged_ = 0;
};

}  // namespace multireach
