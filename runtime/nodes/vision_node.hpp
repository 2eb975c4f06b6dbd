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

  static VisionConfig load(const std::string& path);
};

/// One camera of `cameras`, and a rigid transform given by `translation_m` and `rpy_rad` or `rotation` (row by row).
vision::CameraModel camera_model_from(const Config& config);
Eigen::Isometry3d transform_from(const Config& config);

/// STEREO_IMAGES in, one TARGET out for every message, also when nothing is seen or an image cannot be read.
class VisionNode : public Node {
 public:
  explicit VisionNode(const VisionConfig& config);

  std::string name() const override { return "vision"; }
  std::vector<std::string_view> inputs() const override;
  std::optional<int64_t> receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::string state() const override { return state_; }

  const vision::Sighting& last_sighting() const { return sighting_; }

 private:
  target_t target_of(const images_t& images);

  VisionConfig config_;
  vision::StereoTracker tracker_;
  vision::ImageCodec codec_;
  cv::Mat left_, right_;
  vision::Sighting sighting_;
  target_t last_seen_{};
  int64_t sequence_ = 0;
  SequenceWatch pairs_;
  std::string state_ = "waiting";
};

/// The decimal number under the image metadata "sequence", or -1.
int64_t pair_sequence(const images_t& images);

}  // namespace multireach
