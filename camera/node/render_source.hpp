#pragma once

#include <string>

#include "camera/node/camera_node.hpp"
#include "camera/rendering/ball_path.hpp"
#include "camera/rendering/ball_renderer.hpp"
#include "camera/rendering/tag_renderer.hpp"
#include "imaging/image_codec.hpp"
#include "imaging/side.hpp"
#include "imaging/stereo_rig.hpp"
#include "runtime/config_keys.hpp"

namespace multireach {

/// Renders a ball or a tag on a scripted path, seen by the cameras of a vision file. All randomness is seeded: the same
/// scene file gives the same bytes.
class RenderSource : public CameraSource {
 public:
  /// `scene_path`: a scene file, e.g. logs/reach.yaml. Throws InputError.
  explicit RenderSource(const std::string& scene_path);

  /// The sections of the reference page on a scene file.
  static std::string config_reference();

  std::optional<StereoPair> next() override;
  int64_t next_utime() const override { return scene_.origin_utime + frame_ * 1000000 / scene_.rate_hz; }
  int64_t period_us() const override { return 1000000 / scene_.rate_hz; }
  void skip(int64_t pairs) override { frame_ += pairs; }

 private:
  struct Scene {
    std::string vision{}, target_name = "target";
    int64_t rate_hz = 30, origin_utime = 0;
    double end_s = 0;
    int jpeg_quality = 85;
    SceneOptions options{};
    std::optional<TagLook> tag{};  ///< instead of the ball
    StereoRig rig{};
  };

  static ConfigKeys<Scene> scene_keys();
  static Scene scene_from(const Config& file);
  explicit RenderSource(const Config& file);
  RenderSource(const Config& file, const Scene& scene);
  cv::Mat image_of(Side side, double time_s, bool visible) const;
  Frame frame_of(const cv::Mat& image);
  bool in_both_images(const Eigen::Vector3d& p_WB) const;

  Scene scene_;
  int64_t frames_;
  BallPath path_;
  std::vector<BallRenderer> balls_;  // of the left and the right camera, or none
  std::vector<TagRenderer> tags_;    // likewise
  ImageCodec codec_;
  int64_t frame_ = 0;
};

}  // namespace multireach
