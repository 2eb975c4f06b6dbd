#include "camera/node/device_arguments.hpp"

#include "runtime/program.hpp"

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

CLI::App* add_device_command(CLI::App& cli, DeviceArguments& arguments) {
  CLI::App* device = cli.add_subcommand("device", "two cameras, or one that gives both images side by side");
  device->add_option("--config", arguments.file, "camera file with these and more settings; see docs/cameras.md");
  const char* what = "number or path of a V4L2 device, FIFO with JPEG images, or video file";
  auto* left = device->add_option("--left", arguments.left, what);
  auto* right = device->add_option("--right", arguments.right, what);
  auto* both = device->add_option("--side-by-side", arguments.side_by_side, what);
  left->needs(right)->excludes(both);
  right->needs(left)->excludes(both);
  device->add_option("--width", arguments.width, "width of one image, pixels [640 from a device, any from a file]")
      ->check(CLI::Range(2, 16384));
  device->add_option("--height", arguments.height, "height of one image, pixels [480 from a device, any from a file]")
      ->check(CLI::Range(2, 16384));
  device->add_option("--rate", arguments.rate_hz, "pairs per second [30]")->check(CLI::Range(1, 1000));
  device->add_option("--jpeg-quality", arguments.jpeg_quality, "JPEG quality of encoded images; 0 sends them raw [90]")
      ->check(CLI::Range(0, 100));
  device
      ->add_option("--max-skew", arguments.max_skew_s,
                   "largest difference of the two images' times in a pair, s [half a period]")
      ->check(finite_range(0, 1));
  return device;
}

}  // namespace multireach
