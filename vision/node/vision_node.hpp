#pragma once

#include <multireach/target_t.hpp>

#include "runtime/config.hpp"
#include "runtime/node.hpp"
#include "vision/node/stereo_frames.hpp"
#include "vision/node/vision_config.hpp"
#include "vision/track/frame_watch.hpp"

namespace multireach {

/// STEREO_IMAGES in; out, for every message, one TARGET for each target, also when nothing is seen or an image cannot
/// be read. After a VISION_DEBUG_REQUEST, for two seconds of the images' time, pictures of what it sees on
/// VISION_DEBUG; they are for people, and no log need reproduce them.
class VisionNode : public Node {
 public:
  /// With two threads or more, both images are looked at at the same time.
  explicit VisionNode(const VisionConfig& config, int threads = 1);

  const VisionConfig& config() const { return config_; }
  std::string name() const override { return "vision"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  /// The same for a message that was opened already.
  Receipt conclude(StereoFrames& frames, Outbox& out);
  std::optional<int64_t> replayable() const override { return config_.digest; }
  int64_t sent_per_input() const override { return static_cast<int64_t>(targets_.size()); }
  void skip(int64_t inputs) override { sequence_ += inputs * sent_per_input(); }
  bool adopt(const std::vector<std::span<const uint8_t>>& sent) override;
  std::string state() const override;

 private:
  struct Target {
    std::string name;
    vision::StereoTracker tracker;
    std::array<vision::View, 2> views{};
    vision::Sighting sighting{};
    bool enough = false;  ///< the whole images need not be looked at
    target_t last{};
  };

  bool look(StereoFrames& frames, Side side, bool everywhere);
  bool look_at_both(StereoFrames& frames, bool everywhere);
  const char* fault_of(StereoFrames& frames);
  target_t target_of(Target& target, const StereoFrames& frames, const char* fault);
  void send_debug_picture(StereoFrames& frames, Outbox& out);

  VisionConfig config_;
  std::vector<Target> targets_;
  bool side_by_side_;
  std::array<ImageCodec, 2> codecs_;
  std::array<cv::Mat, 2> buffers_;
  vision::FrameWatch watch_;
  SequenceWatch pairs_;
  int64_t sequence_ = 0;
  std::optional<std::string> picture_of_;  // since the last pair, what somebody asked for; "" for all targets
  std::string shown_;
  int64_t pictures_until_ = -1;
};

}  // namespace multireach
