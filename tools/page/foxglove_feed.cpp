#include "tools/page/foxglove_feed.hpp"

#include "runtime/channels.hpp"
#include "runtime/json_text.hpp"
#include "runtime/message.hpp"
#include "runtime/message_schema.hpp"
#include "tools/foxglove/schemas.hpp"

namespace multireach {
void FoxgloveFeed::receive(std::string_view channel, std::span<const uint8_t> bytes, int64_t utime) {
  // Obstacles are sent once, perhaps before anybody watches; the scene repeats them.
  if (!hub_.watched() && channel != channel::kObstacles) return;
  for (const FoxgloveMessage& message : scene_.messages(channel, bytes, utime)) send(message, utime);
  if (channel == channel::kStereoImages || channel == channel::kVisionDebug) {
    const auto images = decode<images_t>(bytes);
    for (size_t i = 0; images && i < images->images.size(); ++i) {
      const std::string image_schema = foxglove_image_schema(images->images[i].pixelformat);
      const std::string topic = std::string(channel) + "/" + image_side(*images, i);
      if (image_schema.empty() || !hub_.wants(topic, image_schema, [&] { return foxglove_schema(image_schema); }))
        continue;
      if (const auto image = foxglove_image(std::string(channel), *images, i)) send(*image, utime);
    }
    return;
  }
  const MessageSchema* schema = MessageSchemas::project().of(bytes);
  if (!schema) return;
  const std::string topic(channel);
  if (!hub_.wants(topic, "multireach." + schema->name, [&] { return json_schema_of(*schema); })) return;
  if (const auto message = json_of(*schema, bytes)) hub_.publish(topic, utime, json_text(*message));
}

void FoxgloveFeed::send(const FoxgloveMessage& message, int64_t utime) {
  if (hub_.wants(message.topic, message.schema, [&] { return foxglove_schema(message.schema); }))
    hub_.publish(message.topic, utime, json_text(message.message));
}

}  // namespace multireach
