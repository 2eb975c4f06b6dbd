#include "camera/devices/device_options.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/config_keys.hpp"

namespace multireach {
namespace {

/// A number is a device number; a relative path is resolved against the folder of the configuration file.
std::string device_name(const Config& config, const std::string& key) {
  const std::string name = config.text(key, "");
  if (config.has(key) && name.empty()) config.fail(key, "a device number, a device, a FIFO or a video file");
  const bool number = std::ranges::all_of(name, [](char c) { return c >= '0' && c <= '9'; });
  return number ? name : resolve_relative(config.file(), name);
}

ConfigKeys<DeviceOptions> device_keys() {
  using Options = DeviceOptions;
  using Format = DeviceRequest::Format;
  using Turn = Options::Turn;
  const char* device = "number or path";
  return ConfigKeys<Options>("Camera file",
                             "Two cameras for `multireach-camera device`, or one that gives both images side by side.")
      .other("left", device, "", "none", "V4L2 device, FIFO with JPEG images, or video file of the left camera.",
             [](const Config& config, Options& o) { o.left = device_name(config, "left"); })
      .other("right", device, "", "none", "The same for the right camera.",
             [](const Config& config, Options& o) { o.right = device_name(config, "right"); })
      .other("side_by_side", device, "", "none",
             "Instead of both: one device whose images hold left and right, side by side.",
             [](const Config& config, Options& o) { o.side_by_side = device_name(config, "side_by_side"); })
      .integer(
          "width_px", "pixels", 2, 16384, [](auto& o) -> auto& { return o.width; }, "Width of one image.")
      .otherwise("640 from a device, any from a file or FIFO")
      .integer(
          "height_px", "pixels", 2, 16384, [](auto& o) -> auto& { return o.height; }, "Height of one image.")
      .otherwise("480 from a device, any from a file or FIFO")
      .integer(
          "rate_hz", "Hz", 1, 1000, [](auto& o) -> auto& { return o.rate_hz; }, "Stereo pairs per second.")
      .choice<Format>(
          "format", {{"auto", Format::kAuto}, {"MJPG", Format::kMjpg}, {"YUYV", Format::kYuyv}},
          [](auto& o) -> auto& { return o.format; }, "Pixel format asked of a device.")
      .number(
          "exposure_ms", "ms", 0.1, 10000, [](auto& o) -> auto& { return o.exposure_ms; }, "Exposure time.")
      .otherwise("automatic")
      .number(
          "white_balance_k", "K", 1000, 20000, [](auto& o) -> auto& { return o.white_balance_k; },
          "Colour temperature.")
      .otherwise("automatic")
      .number(
          "gain", "the device's", 0, 65535, [](auto& o) -> auto& { return o.gain; }, "Gain.")
      .otherwise("automatic")
      .number(
          "lock_after_s", "s", 0, 3600, [](auto& o) -> auto& { return o.lock_after_s; },
          "Time after opening at which automatic settings are locked.")
      .otherwise("never")
      .integer(
          "jpeg_quality", "", 0, 100, [](auto& o) -> auto& { return o.jpeg_quality; },
          "Quality of images that are not JPEG already; 0: sent raw.")
      .number(
          "max_skew_ms", "ms", 0, 1000, [](auto& o) -> auto& { return o.max_skew_ms; },
          "Largest difference of the two images' times in a pair.")
      .otherwise("half a frame period")
      .choice<Turn>(
          "rotate_180", {{"none", Turn::kNone}, {"left", Turn::kLeft}, {"right", Turn::kRight}, {"both", Turn::kBoth}},
          [](auto& o) -> auto& { return o.rotate_180; }, "Which cameras are mounted upside down.");
}

}  // namespace

void DeviceOptions::check(const std::string& where) const {
  const bool two = !left.empty() && !right.empty(), any = !left.empty() || !right.empty();
  if (any && !side_by_side.empty()) throw InputError(where + ": give left and right, or side by side, not both");
  if (!two && side_by_side.empty()) throw InputError(where + ": give --left and --right, or --side-by-side");
  if (two && left == right) throw InputError(where + ": left and right are the same device, '" + left + "'");
  if (!side_by_side.empty() && (rotate_180 == Turn::kLeft || rotate_180 == Turn::kRight)) {
    throw InputError(where + ": rotate_180 of one side only; an image with both side by side is turned as a whole");
  }
  if (exposure_ms && *exposure_ms * static_cast<double>(rate_hz) > 1000) {
    throw InputError(
        fmt::format("{}: exposure_ms {:g} is longer than the {:.1f} ms from one image to the next at {} Hz", where,
                    *exposure_ms, 1000.0 / static_cast<double>(rate_hz), rate_hz));
  }
}

DeviceOptions load_device_options(const std::string& path) {
  DeviceOptions options;
  device_keys().read(Config::load(path), options);
  return options;
}

std::string device_config_reference() {
  return device_keys().reference();
}

}  // namespace multireach
