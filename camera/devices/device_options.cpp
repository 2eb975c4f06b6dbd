#include "camera/devices/device_options.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/config.hpp"

namespace multireach {
namespace {

/// A number is a device number; a relative path is resolved against the folder of the configuration file.
std::string device_name(const Config& config, const std::string& key) {
  const std::string name = config.text(key, "");
  if (config.has(key) && name.empty()) config.fail(key, "a device number, a device, a FIFO or a video file");
  const bool number = std::ranges::all_of(name, [](char c) { return c >= '0' && c <= '9'; });
  return number ? name : beside(config.file(), name);
}

std::optional<double> given(const Config& config, const std::string& key, double min, double max) {
  if (!config.has(key)) return std::nullopt;
  return config.number(key, min, max);
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
  const Config config = Config::load(path);
  DeviceOptions options;
  options.left = device_name(config, "left");
  options.right = device_name(config, "right");
  options.side_by_side = device_name(config, "side_by_side");
  options.width = static_cast<int>(config.integer("width_px", 2, 16384, options.width));
  options.height = static_cast<int>(config.integer("height_px", 2, 16384, options.height));
  options.rate_hz = config.integer("rate_hz", 1, 1000, options.rate_hz);
  const std::string format = config.choice("format", {"auto", "MJPG", "YUYV"}, "auto");
  if (format == "MJPG") options.format = DeviceRequest::Format::kMjpg;
  if (format == "YUYV") options.format = DeviceRequest::Format::kYuyv;
  options.exposure_ms = given(config, "exposure_ms", 0.1, 10000);
  options.white_balance_k = given(config, "white_balance_k", 1000, 20000);
  options.gain = given(config, "gain", 0, 65535);
  options.lock_after_s = given(config, "lock_after_s", 0, 3600);
  options.jpeg_quality = static_cast<int>(config.integer("jpeg_quality", 0, 100, options.jpeg_quality));
  options.max_skew_ms = given(config, "max_skew_ms", 0, 1000);
  const std::string turn = config.choice("rotate_180", {"none", "left", "right", "both"}, "none");
  if (turn == "left") options.rotate_180 = DeviceOptions::Turn::kLeft;
  if (turn == "right") options.rotate_180 = DeviceOptions::Turn::kRight;
  if (turn == "both") options.rotate_180 = DeviceOptions::Turn::kBoth;
  config.finish();
  return options;
}

}  // namespace multireach
