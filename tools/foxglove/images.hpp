#pragma once

#include <multireach/images_t.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace multireach {

/// A message of one of Foxglove's types.
struct FoxgloveMessage {
  std::string topic, schema;
  nlohmann::ordered_json message;
};

/// Microseconds as Foxglove's time. A time before 1970 is 0.
nlohmann::ordered_json foxglove_time(int64_t utime);

/// "left" or "right", also the frame of that camera; the number of another image type.
std::string image_side(const images_t& images, size_t i);
/// The type of an image with this pixel format: foxglove.CompressedImage or foxglove.RawImage; "" for none.
std::string foxglove_image_schema(int32_t pixel_format);
/// Image i as foxglove.CompressedImage or foxglove.RawImage on TOPIC/left or TOPIC/right; nothing for a pixel format
/// that Foxglove has no name for.
std::optional<FoxgloveMessage> foxglove_image(const std::string& topic, const images_t& images, size_t i);

}  // namespace multireach
