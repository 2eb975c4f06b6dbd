#include "camera/node/render_source.hpp"

#include "runtime/config_keys.hpp"
#include "runtime/rig_config.hpp"

namespace multireach {
namespace {

/// The section `ball` of a scene.
struct Ball {
  double radius_m = SceneOptions{}.ball_radius_m;
  Rgb colour{220, 40, 110};
};

ConfigKeys<Ball> ball_keys() {
  return ConfigKeys<Ball>("Scene file, section ball", "The ball.")
      .number(
          "radius_m", "m", 1e-4, 10, [](auto& b) -> auto& { return b.radius_m; }, "Its radius.")
      .other("rgb", "list of 3 numbers", "0 to 255", "220, 40, 110", "Its colour.",
             [](const Config& config, Ball& ball) {
               if (!config.has("rgb")) return;
               const std::vector<double> rgb = config.numbers("rgb", 3);
               ball.colour = {rgb[0], rgb[1], rgb[2]};
             });
}

ConfigKeys<TagLook> tag_keys() {
  return ConfigKeys<TagLook>("Scene file, section tag", "The AprilTag, of the family 36h11.")
      .integer(
          "id", "", 0, 586, [](auto& t) -> auto& { return t.id; }, "Its number in the family.")
      .required()
      .number(
          "size_m", "m", 1e-3, 10, [](auto& t) -> auto& { return t.size_m; }, "Side of its black square.")
      .required();
}

}  // namespace

ConfigKeys<RenderSource::Scene> RenderSource::scene_keys() {
  return ConfigKeys<Scene>(
             "Scene file",
             "What `multireach-camera render` renders: a ball or a tag before a wall. Paths are relative to the file.")
      .text(
          "vision", [](auto& s) -> auto& { return s.vision; }, "The vision.yaml whose cameras see the scene.")
      .required()
      .text(
          "target_name", [](auto& s) -> auto& { return s.target_name; }, "Name of the target in TARGET_TRUTH.")
      .integer(
          "seed", "", 0, INT64_MAX, [](auto& s) -> auto& { return s.options.seed; },
          "Random seed of the noise and the wall.")
      .integer(
          "rate_hz", "Hz", 1, 1000, [](auto& s) -> auto& { return s.rate_hz; }, "Stereo pairs per second.")
      .integer(
          "origin_utime", "µs", 0, INT64_MAX / 2, [](auto& s) -> auto& { return s.origin_utime; },
          "Time of the first pair.")
      .number(
          "end_s", "s", 0, 1e6, [](auto& s) -> auto& { return s.end_s; }, "Duration of the scene.")
      .required()
      .integer(
          "jpeg_quality", "", 0, 100, [](auto& s) -> auto& { return s.jpeg_quality; },
          "Quality of the JPEG images; 0: raw images.")
      .number(
          "noise_grey_levels", "grey levels", 0, 100, [](auto& s) -> auto& { return s.options.noise_grey_levels; },
          "Standard deviation of the cameras' noise.")
      .number(
          "wall_distance_m", "m", 0.05, 1000, [](auto& s) -> auto& { return s.options.wall_distance_m; },
          "Distance of the wall from the left camera.")
      .integer(
          "distractors", "", 0, 1000, [](auto& s) -> auto& { return s.options.distractors; },
          "Coloured blobs on the wall that are not the ball.")
      .other("ball", "section", "", "all defaults", "The ball.",
             [](const Config& config, Scene& scene) {
               Ball ball;
               if (config.has("ball")) ball_keys().read(config.section("ball"), ball);
               scene.options.ball_radius_m = ball.radius_m;
               scene.options.ball_colour = ball.colour;
             })
      .other("tag", "section", "", "none", "Instead of the ball: an AprilTag with its white margin.",
             [](const Config& config, Scene& scene) {
               if (!config.has("tag")) return;
               if (config.has("ball")) config.fail("tag", "either 'ball' or 'tag', not both");
               tag_keys().read(config.section("tag"), scene.tag.emplace());
             })
      .other("path", "list of sections", "", "required", "How it moves; the first entry has `position_m` at 0 s.",
             [](const Config& config, Scene&) { config.require("path"); });
}

std::string RenderSource::config_reference() {
  return scene_keys().reference() + "\n" + ball_keys().reference() + "\n" + tag_keys().reference() + "\n" +
         BallPath::config_reference();
}

RenderSource::RenderSource(const std::string& scene_path) : RenderSource(Config::load(scene_path)) {}

RenderSource::RenderSource(const Config& file) : RenderSource(file, scene_from(file)) {}

RenderSource::Scene RenderSource::scene_from(const Config& file) {
  Scene scene;
  scene_keys().read(file, scene);
  const RigConfig cameras = load_rig(Config::load(resolve_relative(file.file(), scene.vision)).section("cameras"));
  if (!cameras.has_robot_pose)
    file.fail("vision", "a vision.yaml with cameras.left_to_robot, so that they can be rendered");
  scene.rig = cameras.rig;
  return scene;
}

RenderSource::RenderSource(const Config& file, const Scene& scene)
    : scene_(scene), frames_(static_cast<int64_t>(scene.end_s * static_cast<double>(scene.rate_hz))), path_(file) {
  for (const Eigen::Isometry3d& X_CL : {Eigen::Isometry3d::Identity(), scene.rig.X_RL}) {
    const CameraModel& camera = balls_.empty() && tags_.empty() ? scene.rig.left : scene.rig.right;
    const Eigen::Isometry3d X_WC = scene.rig.X_WL * X_CL.inverse();
    if (scene.tag) {
      tags_.emplace_back(scene.options, *scene.tag, camera, X_WC, scene.rig.X_WL);
    } else {
      balls_.emplace_back(scene.options, camera, X_WC, scene.rig.X_WL);
    }
  }
}

cv::Mat RenderSource::image_of(Side side, double time_s, bool visible) const {
  const auto stream = static_cast<uint64_t>(2 * frame_) + index(side);
  const Eigen::Vector3d p_WT = path_.position(time_s);
  if (balls_.empty()) {
    std::optional<Eigen::Isometry3d> X_WT;
    if (visible) X_WT = Eigen::Translation3d(p_WT) * path_.orientation(time_s);
    return tags_[index(side)].render(X_WT, stream);
  }
  return balls_[index(side)].render(visible ? std::optional(p_WT) : std::nullopt, stream);
}

Frame RenderSource::frame_of(const cv::Mat& image) {
  Frame frame{.utime = next_utime(),
              .width = image.cols,
              .height = image.rows,
              .row_stride = 0,
              .pixelformat = image_t::PIXEL_FORMAT_MJPEG,
              .data = {}};
  if (scene_.jpeg_quality > 0) {
    frame.data = codec_.encode_jpeg(image, scene_.jpeg_quality);
  } else {
    frame.pixelformat = image_t::PIXEL_FORMAT_BGR;
    frame.row_stride = static_cast<int>(image.step);
    frame.data.assign(image.data, image.data + image.total() * image.elemSize());
  }
  return frame;
}

bool RenderSource::in_both_images(const Eigen::Vector3d& p_WB) const {
  const Eigen::Vector3d p_L = scene_.rig.X_WL.inverse() * p_WB;
  const auto inside = [](const CameraModel& camera, const Eigen::Vector3d& p_C) {
    if (p_C.z() <= 0) return false;
    const Eigen::Vector2d pixel = camera.project(p_C);
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera.width - 1 && pixel.y() <= camera.height - 1;
  };
  return inside(scene_.rig.left, p_L) && inside(scene_.rig.right, scene_.rig.X_RL * p_L);
}

std::optional<StereoPair> RenderSource::next() {
  if (frame_ >= frames_) return std::nullopt;
  const double time = static_cast<double>(frame_) / static_cast<double>(scene_.rate_hz);
  const Eigen::Vector3d p_WB = path_.position(time);
  const bool visible = !path_.is_invisible(time);
  StereoPair pair;
  pair.utime = next_utime();
  pair.left = frame_of(image_of(Side::kLeft, time, visible));
  pair.right = frame_of(image_of(Side::kRight, time, visible));
  target_t truth{};
  truth.utime = truth.left_frame_utime = truth.right_frame_utime = pair.utime;
  truth.name = scene_.target_name;
  truth.status = visible && in_both_images(p_WB) ? target_t::STATUS_TRACKED : target_t::STATUS_LOST;
  Eigen::Map<Eigen::Vector3d>(truth.position_m) = p_WB;
  if (scene_.tag) {
    const Eigen::Quaterniond q = path_.orientation(time);
    truth.has_orientation = true;
    Eigen::Map<Eigen::Vector4d>(truth.orientation_wxyz) << q.w(), q.x(), q.y(), q.z();
  }
  pair.truth = truth;
  ++frame_;
  return pair;
}

}  // namespace multireach
