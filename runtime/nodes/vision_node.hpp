#pragma once

#include <multireach/images_t.hpp>
#include <multireach/target_t.hpp>

#include "runtime/config.hpp"
#include "runtime/node.hpp"
#include "vision/image_codec.hpp"
#include "vision/stereo_tracker.hpp"

namespace multireach {

/// The tracker's options and the target's name, from a vision file: sections `cameras`, `colour`, `tracker`.
struct VisionConfig {
  vision::TrackerOptions tracker;
  std::string target_name;
  int64_t digest = 0;  ///< of the file's bytes

  static VisionConfig load(const std::string& path);
};

/// What one message of STEREO_IMAGES shows, whatever came before.
struct Glimpse {
  bool decoded = false;  ///< it is a message of images
  int64_t utime = 0, pair_sequence = -1;
  int64_t left_utime = -1, right_utime = -1;  ///< -1 for an image that is not there
  bool readable = false;                      ///< both images can be read and are of the calibration's size
  vision::View left, right;
};

/// Decodes images and finds blobs. Has no memory: the same message gives the same glimpse.
class Eyes {
 public:
  /// With two threads or more, both images are looked at at the same time.
  Eyes(const VisionConfig& config, int threads);

  Glimpse look(std::span<const uint8_t> message);

 private:
  struct Eye {
    vision::ImageCodec codec;
    cv::Mat bgr;
  };

  vision::StereoTracker tracker_;
  bool side_by_side_;
  Eye left_, right_;
};

/// STEREO_IMAGES in, one TARGET out for every message, also when nothing is seen or an image cannot be read.
class VisionNode : public Node {
 public:
  explicit VisionNode(const VisionConfig& config, int threads = 1);

  std::string name() const override { return "vision"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  /// The same for a message that was looked at already.
  Receipt conclude(const Glimpse& glimpse, Outbox& out);
  std::optional<int64_t> replayable() const override { return config_.digest; }
  void skip(int64_t messages) override { sequence_ += messages; }
  bool adopt(std::span<const uint8_t> sent) override;
  std::string state() const override { return state_; }

 private:
  target_t target_of(const Glimpse& glimpse);

  VisionConfig config_;
  Eyes eyes_;
  vision::StereoTracker tracker_;
  target_t last_seen_{};
  int64_t sequence_ = 0;
  SequenceWatch pairs_;
  std::string state_ = "waiting";
};

/// An image of a message, for the codec; its data stay in the message.
vision::EncodedImage encoded(const image_t& image);
/// The decimal number under the image metadata "sequence", or -1.
int64_t pair_sequence(const images_t& images);

}  // namespace multireach
