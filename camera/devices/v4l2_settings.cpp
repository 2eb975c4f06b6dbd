#include "camera/devices/v4l2_settings.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>

namespace multireach {
namespace {

std::string fourcc(uint32_t code) {
  std::string text;
  for (int shift = 0; shift < 32; shift += 8) text += static_cast<char>(code >> shift & 0x7f);
  return text;
}

std::vector<uint32_t> formats_for(DeviceRequest::Format format) {
  switch (format) {
    case DeviceRequest::Format::kMjpg:
      return {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_JPEG};
    case DeviceRequest::Format::kYuyv:
      return {V4L2_PIX_FMT_YUYV};
    case DeviceRequest::Format::kAuto:
      break;
  }
  return {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_JPEG,  V4L2_PIX_FMT_YUYV,
          V4L2_PIX_FMT_UYVY,  V4L2_PIX_FMT_BGR24, V4L2_PIX_FMT_RGB24};
}

std::string formats_of(const V4l2File& device) {
  std::string list;
  for (uint32_t index = 0; index < 64; ++index) {
    v4l2_fmtdesc description = {};
    description.index = index;
    description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (!device.ask(VIDIOC_ENUM_FMT, &description)) break;
    list += (list.empty() ? "" : ", ") + fourcc(description.pixelformat);
  }
  return list.empty() ? "" : "; it has " + list;
}

std::string sizes_of(const V4l2File& device, uint32_t format) {
  std::string list;
  for (uint32_t index = 0; index < 64; ++index) {
    v4l2_frmsizeenum size = {};
    size.index = index;
    size.pixel_format = format;
    if (!device.ask(VIDIOC_ENUM_FRAMESIZES, &size)) break;
    if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) {
      return fmt::format("; it has {} x {} to {} x {}", size.stepwise.min_width, size.stepwise.min_height,
                         size.stepwise.max_width, size.stepwise.max_height);
    }
    list += fmt::format("{}{} x {}", list.empty() ? "" : ", ", size.discrete.width, size.discrete.height);
  }
  return list.empty() ? "" : "; it has " + list;
}

struct Setting {
  uint32_t control;
  int32_t value;
};

/// Sets a control and reads it back. Returns "" on success, else what went wrong.
std::string set_control(const V4l2File& device, const Setting& setting) {
  v4l2_queryctrl range = {};
  range.id = setting.control;
  if (!device.ask(VIDIOC_QUERYCTRL, &range) || (range.flags & V4L2_CTRL_FLAG_DISABLED))
    return "the device has no such control";
  if (setting.value < range.minimum || setting.value > range.maximum) {
    return fmt::format("the device accepts {} to {}, not {}", range.minimum, range.maximum, setting.value);
  }
  v4l2_control control{setting.control, setting.value};
  if (!device.ask(VIDIOC_S_CTRL, &control)) return std::strerror(errno);
  // Drivers round values to the control's step.
  if (device.ask(VIDIOC_G_CTRL, &control) && std::abs(control.value - setting.value) > std::max(range.step, 1)) {
    return fmt::format("the device made {} of {}", control.value, setting.value);
  }
  return "";
}

/// A setting that the camera can also control automatically.
struct Automatic {
  const char* name;  ///< configuration key
  std::optional<double> wanted;
  double scale;  ///< control units per configured unit
  Setting off;
  uint32_t control;
};

std::array<Automatic, 3> automatics(const DeviceRequest& request) {
  return {{{"exposure_ms",
            request.exposure_ms,
            10,
            {V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL},
            V4L2_CID_EXPOSURE_ABSOLUTE},
           {"gain", request.gain, 1, {V4L2_CID_AUTOGAIN, 0}, V4L2_CID_GAIN},
           {"white_balance_k",
            request.white_balance_k,
            1,
            {V4L2_CID_AUTO_WHITE_BALANCE, 0},
            V4L2_CID_WHITE_BALANCE_TEMPERATURE}}};
}

}  // namespace

std::string set_format(const V4l2File& device, const DeviceRequest& request, v4l2_pix_format& given) {
  const auto width = static_cast<uint32_t>(request.width > 0 ? request.width : 640);
  const auto height = static_cast<uint32_t>(request.height > 0 ? request.height : 480);
  std::string fault;
  for (const uint32_t code : formats_for(request.format)) {
    v4l2_format format = {};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    format.fmt.pix.width = width;
    format.fmt.pix.height = height;
    format.fmt.pix.pixelformat = code;
    format.fmt.pix.field = V4L2_FIELD_ANY;
    if (!device.ask(VIDIOC_S_FMT, &format)) {
      if (errno == EINVAL) continue;  // unknown pixel format
      if (errno == EBUSY) return fmt::format("'{}': is in use by another program", device.name);
      return fmt::format("'{}': does not take a format ({})", device.name, std::strerror(errno));
    }
    given = format.fmt.pix;
    if (given.pixelformat != code) continue;  // drivers substitute a format that they have
    if (given.width == width && given.height == height) return "";
    if (fault.empty()) {
      fault = fmt::format("'{}': gives images of {} x {} pixels, not {} x {} as asked{}", device.name, given.width,
                          given.height, width, height, sizes_of(device, code));
    }
  }
  if (!fault.empty()) return fault;
  const char* asked = request.format == DeviceRequest::Format::kAuto   ? "a format that can be sent"
                      : request.format == DeviceRequest::Format::kYuyv ? "YUYV"
                                                                       : "MJPG";
  return fmt::format("'{}': does not give {}{}", device.name, asked, formats_of(device));
}

std::vector<std::string> set_rate(const V4l2File& device, int64_t rate_hz) {
  v4l2_streamparm parameters = {};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  parameters.parm.capture.timeperframe = {1, static_cast<uint32_t>(rate_hz)};
  if (!device.ask(VIDIOC_S_PARM, &parameters)) {
    return {fmt::format("'{}': its rate cannot be set ({})", device.name, std::strerror(errno))};
  }
  const v4l2_fract& period = parameters.parm.capture.timeperframe;
  if (period.numerator == 0 || period.denominator == 0) return {};
  const double given = static_cast<double>(period.denominator) / period.numerator;
  if (std::abs(given - static_cast<double>(rate_hz)) <= 0.02 * static_cast<double>(rate_hz)) return {};
  return {fmt::format("'{}': gives {:.4g} images per second, not {} as asked", device.name, given, rate_hz)};
}

std::vector<std::string> set_controls(const V4l2File& device, const DeviceRequest& request) {
  // Otherwise the camera may lower its frame rate in the dark.
  set_control(device, {V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0});
  std::vector<std::string> remarks;
  for (const Automatic& automatic : automatics(request)) {
    if (!automatic.wanted) continue;
    set_control(device, automatic.off);  // fails on devices without automatic control, which is harmless
    const double value = *automatic.wanted;
    const std::string fault =
        set_control(device, {automatic.control, static_cast<int32_t>(std::lround(value * automatic.scale))});
    if (fault.empty()) continue;
    remarks.push_back(fmt::format("'{}': {} {:g} was not accepted: {}", device.name, automatic.name, value, fault));
  }
  return remarks;
}

std::vector<std::string> lock_controls(const V4l2File& device, const DeviceRequest& request) {
  std::vector<std::string> remarks;
  for (const Automatic& automatic : automatics(request)) {
    if (automatic.wanted) continue;
    v4l2_control now{automatic.control, 0};
    std::string fault = "the device does not tell it";
    if (device.ask(VIDIOC_G_CTRL, &now)) fault = set_control(device, automatic.off);
    // Some devices return to an older manual value when the automatic control is switched off.
    if (fault.empty()) fault = set_control(device, {automatic.control, now.value});
    remarks.push_back(fault.empty() ? fmt::format("'{}': {} is locked at {:g}", device.name, automatic.name,
                                                  now.value / automatic.scale)
                                    : fmt::format("'{}': {} cannot be locked: {}", device.name, automatic.name, fault));
  }
  return remarks;
}

}  // namespace multireach
