#pragma once

#include "runtime/nodes/vision_node.hpp"
#include "tools/camera/ball_path.hpp"
#include "tools/camera/ball_renderer.hpp"
#include "tools/camera/camera_node.hpp"

namespace multireach {

/// A rendered ball on a scripted path, seen by the cameras of a vision file. Everything is seeded: the same scene file
/// gives the same bytes.
class RenderSource : public CameraSource {
 public:
  /// `scene_path`: see logs/reach.yaml. Throws InputError.
  explicit RenderSource(const std::string& scene_path);

  std::optional<StereoPair> next() override;
  int64_t next_utime() const override { return origin_utime_ + frame_ * 1000000 / rate_hz_; }
  int64_t period_us() const override { return 1000000 / rate_hz_; }

 private:
  RenderSource(const Config& scene, const VisionConfig& vision);
  Frame frame_of(const BallRenderer& renderer, const std::optional<Eigen::Vector3d>& ball, uint64_t stream);
  bool in_both_images(const Eigen::Vector3d& p_WB) const;

  VisionConfig vision_;
  int64_t rate_hz_, origin_utime_, frames_;
  int jpeg_quality_;
  SceneOptions options_;
  BallPath path_;
  BallRenderer left_, right_;
  vision::ImageCodec codec_;
  int64_t frame_ = 0;
};

}  // namespace multireach
