#pragma once

#include <string>

#include "camera/node/camera_node.hpp"
#include "camera/rendering/ball_path.hpp"
#include "camera/rendering/ball_renderer.hpp"
#include "imaging/image_codec.hpp"
#include "imaging/stereo_rig.hpp"

namespace multireach {

/// Renders a ball on a scripted path, seen by the cameras of a vision file. All randomness is seeded: the same scene
/// file gives the same bytes.
class RenderSource : public CameraSource {
 public:
  /// `scene_path`: a scene file, e.g. logs/reach.yaml. Throws InputError.
  explicit RenderSource(const std::string& scene_path);

  std::optional<StereoPair> next() override;
  int64_t next_utime() const override { return origin_utime_ + frame_ * 1000000 / rate_hz_; }
  int64_t period_us() const override { return 1000000 / rate_hz_; }

 private:
  RenderSource(const Config& scene, const StereoRig& rig);
  Frame frame_of(const BallRenderer& renderer, const std::optional<Eigen::Vector3d>& ball, uint64_t stream);
  bool in_both_images(const Eigen::Vector3d& p_WB) const;

  StereoRig rig_;
  std::string target_name_;
  int64_t rate_hz_, origin_utime_, frames_;
  int jpeg_quality_;
  SceneOptions options_;
  BallPath path_;
  BallRenderer left_, right_;
  ImageCodec codec_;
  int64_t frame_ = 0;
};

}  // namespace multireach
