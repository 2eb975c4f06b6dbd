#pragma once

#include <array>
#include <memory>
#include <multireach/images_t.hpp>
#include <span>

#include "imaging/image_codec.hpp"
#include "vision/stereo_tracker.hpp"

namespace multireach {

/// One message of STEREO_IMAGES, its images decoded as far as anyone asked. What it shows does not depend on how they
/// were asked for, so a replay may decode everything beforehand.
class StereoFrames {
 public:
  StereoFrames() = default;
  /// Nothing but `decoded` is meaningful when the message is none of images.
  explicit StereoFrames(std::span<const uint8_t> message);

  bool decoded() const { return images_ != nullptr; }
  int64_t utime() const { return images_->utime; }
  /// The decimal number under the image metadata "sequence", or -1.
  int64_t pair_sequence() const { return pair_sequence_; }
  /// Capture time, microseconds; -1 where there is no such image.
  int64_t frame_utime(Side side) const;
  /// Whether there is such an image of this size; it may still be damaged.
  bool has(Side side, int width, int height) const;
  /// A number that tells this image's bytes from those of others; 0 where there is no such image.
  int64_t fingerprint(Side side) const;

  /// The image, valid at least in `part`; null when it cannot be decoded there. Both sides may be asked at the same
  /// time, each with a codec of its own.
  const cv::Mat* pixels(Side side, const cv::Rect& part, ImageCodec& codec);
  /// Memory to decode into, so that a live node allocates none.
  void lend(Side side, const cv::Mat& buffer) { sides_[index(side)].bgr = buffer; }
  cv::Mat buffer(Side side) const { return sides_[index(side)].bgr; }

 private:
  struct OneSide {
    const image_t* image = nullptr;
    cv::Mat bgr;
    cv::Rect valid;
  };
  static size_t index(Side side) { return side == Side::kLeft ? 0 : 1; }

  std::unique_ptr<images_t> images_;  // their addresses must not change
  int64_t pair_sequence_ = -1;
  std::array<OneSide, 2> sides_;
};

}  // namespace multireach
