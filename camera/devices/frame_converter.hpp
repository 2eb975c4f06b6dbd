#pragma once

#include <string>
#include <variant>
#include <vector>

#include "camera/devices/camera_device.hpp"
#include "camera/pairing/frame.hpp"

namespace multireach {

/// How a device's images are converted to frames.
struct FrameConversion {
  int width = 0, height = 0;  ///< of the whole image, pixels; 0: as the first image
  int jpeg_quality = 90;      ///< for images that are not JPEG; 0 sends them raw
  bool side_by_side = false;  ///< the image contains left and right, side by side
  bool rotate_180 = false;    ///< applied before the image is split
};

/// Converts an image to a frame, or to a left and a right one. JPEG images are not decoded where possible: they are
/// passed on unchanged, or rotated and split losslessly on their blocks (tjTransform).
class FrameConverter {
 public:
  explicit FrameConverter(const FrameConversion& form);
  ~FrameConverter();
  FrameConverter(const FrameConverter&) = delete;
  FrameConverter& operator=(const FrameConverter&) = delete;

  /// The frames, two when side by side; or the reason why there are none, as a predicate for a subject that the caller
  /// names ("gave an image that ...").
  std::variant<std::vector<Frame>, std::string> convert(RawImage image, int64_t utime);

 private:
  std::string refuse_size(const RawImage& image);
  std::vector<Frame> transformed(const RawImage& jpeg, int64_t utime);
  std::variant<std::vector<Frame>, std::string> reencoded(const RawImage& image, int64_t utime);

  struct Handles;
  FrameConversion form_;
  std::unique_ptr<Handles> handles_;
};

}  // namespace multireach
