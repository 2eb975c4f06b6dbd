#pragma once

#include <multireach/target_candidates_t.hpp>
#include <multireach/target_t.hpp>
#include <multireach/tracker_state_t.hpp>

#include "runtime/config.hpp"
#include "runtime/node.hpp"
#include "vision/node/debug_picture.hpp"
#include "vision/node/stereo_frames.hpp"
#include "vision/node/vision_config.hpp"
#include "vision/tag_vision.hpp"

namespace multireach {

/// Receives STEREO_IMAGES. For every message it sends one TARGET per target, also when nothing is found or an image
/// cannot be decoded, and TARGET_CANDIDATES where a coloured one has several candidates, or none is chosen. After a
/// VISION_DEBUG_REQUEST it sends debug pictures on VISION_DEBUG for two seconds of image time; replay does not have to
/// reproduce those.
class VisionNode : public Node {
 public:
  /// With two or more threads, the two images are processed concurrently.
  explicit VisionNode(const VisionConfig& config, int threads = 1);

  const VisionConfig& config() const { return config_; }
  std::string name() const override { return "vision"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  bool takes_newest(std::string_view channel) const override;
  void leave_out(std::string_view channel, std::span<const uint8_t> bytes) override;
  /// Like receive(), for STEREO_IMAGES that were decoded already.
  Receipt process(StereoFrames& frames, Outbox& out);
  std::optional<int64_t> config_digest() const override { return config_.digest; }
  int64_t sent_per_input() const override { return static_cast<int64_t>(last_.size()); }
  void skip_inputs(int64_t inputs, std::string_view) override { sequence_ += inputs * sent_per_input(); }
  bool restore_from_outputs(const std::vector<std::span<const uint8_t>>& outputs) override;
  std::string state() const override;

 private:
  std::optional<int64_t> newest_utime() const;
  target_t target_message(size_t k, const StereoFrames& frames, const vision::TargetReport& report);
  target_t coloured_target_message(size_t k, const StereoFrames& frames, const char* fault);
  target_t tag_message(size_t k, const StereoFrames& frames, const char* fault);
  tracker_state_t tracker_state_message(size_t k) const;
  std::optional<target_candidates_t> candidates_message(size_t k) const;
  vision::DebugMarks marks_of(size_t k) const;
  std::string remarks() const;
  void send_debug_picture(StereoFrames& frames, Outbox& out);

  VisionConfig config_;
  std::optional<vision::StereoVision> vision_;  // nothing where all targets are tags
  vision::TagVision tags_;
  std::vector<target_t> last_;  // message of each target for the last pair: the coloured ones, then the tags
  bool side_by_side_;
  std::array<ImageCodec, 2> codecs_;
  std::array<cv::Mat, 2> buffers_;
  SequenceGapCounter pairs_;
  int64_t sequence_ = 0;
  std::optional<std::string> picture_of_;  // target of a pending debug request; "" for all targets
  std::string shown_;
  int64_t pictures_until_ = -1;
  int64_t pictured_ = INT64_MIN / 2;  // time of the last debug picture
};

}  // namespace multireach
