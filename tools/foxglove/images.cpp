#include "tools/foxglove/images.hpp"

#include <algorithm>

#include "runtime/message_schema.hpp"

namespace multireach {
namespace {

/// Foxglove's name of a pixel format; nothing if it has none.
std::optional<std::string> encoding_of(int32_t pixel_format) {
  switch (pixel_format) {
    case image_t::PIXEL_FORMAT_GRAY:
      return "mono8";
    case image_t::PIXEL_FORMAT_RGB:
      return "rgb8";
    case image_t::PIXEL_FORMAT_BGR:
      return "bgr8";
    case image_t::PIXEL_FORMAT_YUYV:
      return "yuyv";
    case image_t::PIXEL_FORMAT_UYVY:
      return "uyvy";
    case image_t::PIXEL_FORMAT_BAYER_BGGR:
      return "bayer_bggr8";
    case image_t::PIXEL_FORMAT_BAYER_GBRG:
      return "bayer_gbrg8";
    case image_t::PIXEL_FORMAT_BAYER_GRBG:
      return "bayer_grbg8";
    case image_t::PIXEL_FORMAT_BAYER_RGGB:
      return "bayer_rggb8";
    default:
      return std::nullopt;
  }
}

}  // namespace

nlohmann::ordered_json foxglove_time(int64_t utime) {
  const int64_t us = std::max<int64_t>(utime, 0);
  return {{"sec", us / 1000000}, {"nsec", us % 1000000 * 1000}};
}

std::string image_side(const images_t& images, size_t i) {
  const auto type = images.image_types[i];
  return type == images_t::LEFT ? "left" : type == images_t::RIGHT ? "right" : std::to_string(type);
}

std::string foxglove_image_schema(int32_t pixel_format) {
  if (pixel_format == image_t::PIXEL_FORMAT_MJPEG) return "foxglove.CompressedImage";
  return encoding_of(pixel_format) ? "foxglove.RawImage" : "";
}

std::optional<FoxgloveMessage> foxglove_image(const std::string& topic, const images_t& images, size_t i) {
  const image_t& image = images.images[i];
  const std::string side = image_side(images, i);
  FoxgloveMessage out{topic + "/" + side,
                      foxglove_image_schema(image.pixelformat),
                      {{"timestamp", foxglove_time(image.utime)}, {"frame_id", side}}};
  if (image.pixelformat == image_t::PIXEL_FORMAT_MJPEG) {
    out.message["data"] = base64(image.data);
    out.message["format"] = "jpeg";
    return out;
  }
  const auto encoding = encoding_of(image.pixelformat);
  if (!encoding) return std::nullopt;
  out.message["width"] = image.width;
  out.message["height"] = image.height;
  out.message["encoding"] = *encoding;
  out.message["step"] = image.row_stride;
  out.message["data"] = base64(image.data);
  return out;
}

}  // namespace multireach
