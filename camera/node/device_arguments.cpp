#include "camera/node/device_arguments.hpp"

namespace multireach {

DeviceOptions DeviceArguments::options() const {
  DeviceOptions options;
  if (!file.empty()) options = load_device_options(file);
  if (left || right || side_by_side) {
    options.left = left.value_or("");
    options.right = right.value_or("");
    options.side_by_side = side_by_side.value_or("");
  }
  options.width = width.value_or(options.width);
  options.height = height.value_or(options.height);
  options.rate_hz = rate_hz.value_or(options.rate_hz);
  options.jpeg_quality = jpeg_quality.value_or(options.jpeg_quality);
  if (max_skew_s) options.max_skew_ms = *max_skew_s * 1e3;
  options.check(file.empty() ? "device" : file);
  return options;
}

void add_device_command(CommandLine& cli, DeviceArguments& arguments) {
  CommandLine device = cli.subcommand("device", "two cameras, or one that gives both images side by side");
  device.option("--config", arguments.file, "camera file with these and more settings; see docs/cameras.md");
  const char* what = "number or path of a V4L2 device, FIFO with JPEG images, or video file";
  CommandOption left = device.option("--left", arguments.left, what);
  CommandOption right = device.option("--right", arguments.right, what);
  const CommandOption both = device.option("--side-by-side", arguments.side_by_side, what);
  left.needs(right).excludes(both);
  right.needs(left).excludes(both);
  device.option("--width", arguments.width, "width of one image, pixels [640 from a device, any from a file]")
      .whole(2, 16384);
  device.option("--height", arguments.height, "height of one image, pixels [480 from a device, any from a file]")
      .whole(2, 16384);
  device.option("--rate", arguments.rate_hz, "pairs per second [30]").whole(1, 1000);
  device.option("--jpeg-quality", arguments.jpeg_quality, "JPEG quality of encoded images; 0 sends them raw [90]")
      .whole(0, 100);
  device
      .option("--max-skew", arguments.max_skew_s,
              "largest difference of the two images' times in a pair, s [half a period]")
      .finite(0, 1);
}

}  // namespace multireach
