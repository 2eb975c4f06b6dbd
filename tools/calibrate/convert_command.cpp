#include <spdlog/spdlog.h>

#include <memory>

#include "tools/calibrate/camera_output.hpp"
#include "tools/calibrate/commands.hpp"

namespace multireach {
namespace {

struct ConvertOptions {
  std::vector<std::string> inputs;
  CameraOutput output;
  std::string size, unit;
};

int convert(const ConvertOptions& options) {
  CameraFileHints hints;
  if (!options.size.empty()) {
    const auto [width, height] = parse_size("--size", options.size, 2, 16384);
    hints.width = width;
    hints.height = height;
  }
  if (!options.unit.empty()) hints.unit_m = unit_length_m("--unit", options.unit);
  if (options.inputs.size() > 2) throw InputError("convert: at most two files make one calibration");
  options.output.check();
  const CameraFiles files = read_camera_files(options.inputs, hints);
  for (const std::string& sentence : files.assumptions) spdlog::info("{}", sentence);
  options.output.write(files.rig, files.has_robot_pose);
  return 0;
}

}  // namespace

Command convert_command(CommandLine& cli) {
  const auto options = std::make_shared<ConvertOptions>();
  CommandLine app = cli.subcommand("convert", "a calibration in another format; all lengths in metres");
  app.option("FILE", options->inputs,
             "OpenCV stereo YAML (or intrinsics and extrinsics), two files of ROS camera_info (left, right), Kalibr "
             "camchain, or a vision file")
      .required();
  app.option("--size", options->size, "WxH: the images' size, pixels, where the file does not say it");
  app.option("--unit", options->unit, "m, cm, mm or inch: the unit of the baseline, if the file lacks it");
  options->output.add_options(app);
  return {app, [options] { return convert(*options); }};
}

}  // namespace multireach
