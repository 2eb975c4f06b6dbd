#pragma once

#include <array>
#include <memory>
#include <multireach/images_t.hpp>
#include <span>

#include "imaging/image_codec.hpp"
#include "imaging/side.hpp"

namespace multireach {

/// One STEREO_IMAGES message with lazily decoded images. The pixels do not depend on which parts were requested before,
/// so a replay may decode everything in advance.
class StereoFrames {
 public:
  StereoFrames() = default;
  /// When the message is not a valid images_t, is_valid() returns false and the other members have no meaning.
  explicit StereoFrames(std::span<const uint8_t> message);

  bool is_valid() const { return images_ != nullptr; }
  int64_t utime() const { return images_->utime; }
  /// Sequence number from the image metadata "sequence" (decimal text); -1 if absent.
  int64_t pair_sequence() const { return pair_sequence_; }
  /// Capture time, microseconds; -1 where there is no such image.
  int64_t frame_utime(Side side) const;
  /// Whether there is such an image of this size; it may still be damaged.
  bool has(Side side, int width, int height) const;
  /// Hash of this image's bytes; 0 where there is no such image.
  int64_t fingerprint(Side side) const;

  /// The image, valid at least in `part`; null when it cannot be decoded there. Both sides may be requested
  /// concurrently, each with its own codec.
  const cv::Mat* pixels(Side side, const cv::Rect& part, ImageCodec& codec);
  /// Whether this image is encoded with chroma of a lower resolution than its luma.
  bool chroma_subsampled(Side side) const;
  /// Provides a buffer to decode into, so that a live node does not allocate.
  void set_buffer(Side side, const cv::Mat& buffer) { sides_[index(side)].bgr = buffer; }
  cv::Mat buffer(Side side) const { return sides_[index(side)].bgr; }

 private:
  struct OneSide {
    const image_t* image = nullptr;
    cv::Mat bgr;
    cv::Rect valid;
  };

  std::unique_ptr<images_t> images_;  // on the heap, because sides_ points into it
  int64_t pair_sequence_ = -1;
  std::array<OneSide, 2> sides_;
};

}  // namespace multireach
