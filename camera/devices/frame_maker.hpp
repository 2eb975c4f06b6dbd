#pragma once

#include <string>
#include <variant>
#include <vector>

#include "camera/devices/camera_device.hpp"
#include "camera/pairing/frame.hpp"

namespace multireach {

/// How images of a device become frames.
struct FrameForm {
  int width = 0, height = 0;  ///< of the whole image, pixels; 0: those of the first one
  int jpeg_quality = 90;      ///< of images that are not JPEG; 0 sends them raw
  bool side_by_side = false;  ///< the image holds left and right beside each other
  bool rotate_180 = false;    ///< before it is divided
};

/// The frame, or the left and the right one, of an image. JPEG images are not decoded where that can be avoided: they
/// are sent as they came, or turned and divided on their blocks without loss (tjTransform).
class FrameMaker {
 public:
  explicit FrameMaker(const FrameForm& form);
  ~FrameMaker();
  FrameMaker(const FrameMaker&) = delete;
  FrameMaker& operator=(const FrameMaker&) = delete;

  /// The frames, two when side by side; or why there are none, to go on from "it".
  std::variant<std::vector<Frame>, std::string> make(RawImage image, int64_t utime);

 private:
  std::string refuse_size(const RawImage& image);
  std::vector<Frame> transformed(const RawImage& jpeg, int64_t utime);
  std::variant<std::vector<Frame>, std::string> redone(const RawImage& image, int64_t utime);

  struct Handles;
  FrameForm form_;
  std::unique_ptr<Handles> handles_;
};

/// An 8-bit BGR image as a frame: a JPEG of this quality, or as it is for 0.
Frame frame_of(ImageCodec& codec, const cv::Mat& bgr, int64_t utime, int jpeg_quality);

}  // namespace multireach
