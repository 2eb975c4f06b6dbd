#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace multireach {

/// Where a JPEG image ends and how large it is, told from its markers (ITU T.81, annex B) without decoding it.
struct JpegExtent {
  enum class Kind {
    kWhole,       ///< from SOI to EOI, with a frame header and a scan
    kIncomplete,  ///< right so far; the end is missing
    kBroken,      ///< not a JPEG image from its beginning
  };
  Kind kind = Kind::kBroken;
  size_t bytes = 0;           ///< whole: from SOI to EOI; else how far it was understood
  int width = 0, height = 0;  ///< pixels; 0 before the frame header
};
JpegExtent jpeg_extent(std::span<const uint8_t> bytes);

/// JPEG images out of a stream of bytes. What stands between them is skipped, so a bare sequence of JPEGs, an AVI with
/// MJPG, and the multipart stream of a network camera are all understood, also from their middle.
class JpegStream {
 public:
  struct Image {
    int width = 0, height = 0;
    std::vector<uint8_t> data;
  };

  void put(std::span<const uint8_t> bytes);
  /// The next whole image, or nothing when more bytes are needed.
  std::optional<Image> next();
  /// Images that began and were broken, or cut off by the next one, since the start.
  int64_t damaged() const { return damaged_; }
  /// Bytes that wait for the end of their image.
  size_t pending() const { return bytes_.size(); }

 private:
  std::vector<uint8_t> bytes_;
  int64_t damaged_ = 0;
};

}  // namespace multireach
