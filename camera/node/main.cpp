// multireach-camera: publishes stereo images from a rendered scene, image files or devices.
#include "camera/node/device_arguments.hpp"
#include "camera/node/device_source.hpp"
#include "camera/node/file_sources.hpp"
#include "camera/node/practice_node.hpp"
#include "camera/node/render_source.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/program.hpp"
#include "runtime/rig_config.hpp"
#include "runtime/robot_config.hpp"

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-camera", "Stereo images on STEREO_IMAGES: rendered, from files, or from devices.");
  CommandLine& cli = program.cli();
  cli.fallthrough();
  cli.require_subcommand();
  const LiveOptions& live = program.add_live_options();
  program.add_config_reference([] { return RenderSource::config_reference() + "\n" + device_config_reference(); });

  std::string scene;
  bool drop_late = false;
  CommandLine render = cli.subcommand("render", "a ball on a scripted path, with the truth on TARGET_TRUTH");
  render.option("--config", scene, "scene file, as logs/reach.yaml").required();
  render.flag("--drop-late", drop_late,
              "leave out pairs that are late by a period or more, as a camera does; without, each is sent, and the "
              "recording is always the same");

  ImagesOptions images;
  CommandLine files = cli.subcommand("images", "pairs of image files");
  files.option("--left", images.left, "file, folder or pattern").required();
  files.option("--right", images.right, "file, folder or pattern").required();
  files.option("--rate", images.rate_hz, "pairs per second").whole(1, 1000).show_default();
  files.option("--repeat", images.repeat, "number of times to send the whole list").whole(1, 1000000000).show_default();
  files.option("--origin-utime", images.origin_utime, "time of the first pair, microseconds").show_default();
  files.option("--jpeg-quality", images.jpeg_quality, "JPEG quality of encoded images; 0 sends raw BGR")
      .whole(0, 100)
      .show_default();

  std::string robot, vision;
  CommandLine practice =
      cli.subcommand("practice", "what the set-up course of multireach-page shows, before rendered cameras");
  practice.option("--robot", robot, "robot.yaml or its folder: whose hand holds the ball").required();
  practice.option("--vision", vision, "vision.yaml of the rendered cameras: what the course shall find out").required();

  DeviceArguments devices;
  add_device_command(cli, devices);

  return program.run(argc, argv, [&] {
    cv::setNumThreads(1);
    if (practice.given()) {
      const RigConfig cameras = load_rig(Config::load(vision).section("cameras"));
      if (!cameras.has_robot_pose)
        throw InputError(vision + ": has no left_to_robot, without which nothing can be rendered");
      PracticeNode node(RobotConfig::load(robot).chain, {.rig = cameras.rig}, wall_us());
      return run_live(node, live);
    }
    std::unique_ptr<CameraSource> source;
    if (render.given()) {
      source = std::make_unique<RenderSource>(scene);
    } else if (files.given()) {
      source = make_images_source(images);
    } else {
      if (live.speed != 1) throw InputError("device: --speed must be 1: cameras cannot be made slower or faster");
      source = make_device_source(devices.options());
    }
    CameraNode node(std::move(source), drop_late ? LateTicks::kSkip : LateTicks::kCompute);
    return run_live(node, live);
  });
}
