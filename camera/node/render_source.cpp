#include "camera/node/render_source.hpp"

#include "runtime/rig_config.hpp"

namespace multireach {
namespace {

SceneOptions scene_options_from(const Config& scene) {
  SceneOptions options;
  options.seed = static_cast<uint64_t>(scene.integer("seed", 0, INT64_MAX, 1));
  options.noise_grey_levels = scene.number("noise_grey_levels", 0, 100, options.noise_grey_levels);
  options.wall_distance_m = scene.number("wall_distance_m", 0.05, 1000, options.wall_distance_m);
  options.distractors = static_cast<int>(scene.integer("distractors", 0, 1000, options.distractors));
  if (scene.has("ball")) {
    const Config ball = scene.section("ball");
    options.ball_radius_m = ball.number("radius_m", 1e-4, 10, options.ball_radius_m);
    const std::vector<double> rgb = ball.numbers("rgb", 3, std::vector<double>{220, 40, 110});
    options.ball_colour = {rgb[0], rgb[1], rgb[2]};
    ball.finish();
  }
  return options;
}

Config checked(const Config& scene) {
  scene.finish({"vision", "target_name", "seed", "rate_hz", "origin_utime", "end_s", "jpeg_quality",
                "noise_grey_levels", "wall_distance_m", "distractors", "ball", "path"});
  return scene;
}

}  // namespace

RenderSource::RenderSource(const std::string& scene_path)
    : RenderSource(
          checked(Config::load(scene_path)),
          load_rig(Config::load(beside(scene_path, Config::load(scene_path).text("vision"))).section("cameras")).rig) {}

RenderSource::RenderSource(const Config& scene, const StereoRig& rig)
    : rig_(rig),
      target_name_(scene.text("target_name", "target")),
      rate_hz_(scene.integer("rate_hz", 1, 1000, 30)),
      origin_utime_(scene.integer("origin_utime", 0, INT64_MAX / 2, 0)),
      frames_(static_cast<int64_t>(scene.number("end_s", 0, 1e6) * static_cast<double>(rate_hz_))),
      jpeg_quality_(static_cast<int>(scene.integer("jpeg_quality", 0, 100, 85))),
      options_(scene_options_from(scene)),
      path_(scene),
      left_(options_, rig.left, rig.X_WL, rig.X_WL),
      right_(options_, rig.right, rig.X_WL * rig.X_RL.inverse(), rig.X_WL) {}

Frame RenderSource::frame_of(const BallRenderer& renderer, const std::optional<Eigen::Vector3d>& ball,
                             uint64_t stream) {
  const cv::Mat image = renderer.render(ball, stream);
  Frame frame{.utime = next_utime(),
              .width = image.cols,
              .height = image.rows,
              .row_stride = 0,
              .pixelformat = image_t::PIXEL_FORMAT_MJPEG,
              .data = {}};
  if (jpeg_quality_ > 0) {
    frame.data = codec_.encode_jpeg(image, jpeg_quality_);
  } else {
    frame.pixelformat = image_t::PIXEL_FORMAT_BGR;
    frame.row_stride = static_cast<int>(image.step);
    frame.data.assign(image.data, image.data + image.total() * image.elemSize());
  }
  return frame;
}

bool RenderSource::in_both_images(const Eigen::Vector3d& p_WB) const {
  const Eigen::Vector3d p_L = rig_.X_WL.inverse() * p_WB;
  const auto inside = [](const CameraModel& camera, const Eigen::Vector3d& p_C) {
    if (p_C.z() <= 0) return false;
    const Eigen::Vector2d pixel = camera.project(p_C);
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera.width - 1 && pixel.y() <= camera.height - 1;
  };
  return inside(rig_.left, p_L) && inside(rig_.right, rig_.X_RL * p_L);
}

std::optional<StereoPair> RenderSource::next() {
  if (frame_ >= frames_) return std::nullopt;
  const double time = static_cast<double>(frame_) / static_cast<double>(rate_hz_);
  const Eigen::Vector3d p_WB = path_.position(time);
  std::optional<Eigen::Vector3d> ball;
  if (!path_.hidden(time)) ball = p_WB;
  StereoPair pair;
  pair.utime = next_utime();
  const auto stream = static_cast<uint64_t>(2 * frame_);
  pair.left = frame_of(left_, ball, stream);
  pair.right = frame_of(right_, ball, stream + 1);
  target_t truth{};
  truth.utime = truth.left_frame_utime = truth.right_frame_utime = pair.utime;
  truth.name = target_name_;
  truth.status = ball && in_both_images(*ball) ? target_t::STATUS_TRACKED : target_t::STATUS_LOST;
  Eigen::Map<Eigen::Vector3d>(truth.position_m) = p_WB;
  pair.truth = truth;
  ++frame_;
  return pair;
}

}  // namespace multireach
