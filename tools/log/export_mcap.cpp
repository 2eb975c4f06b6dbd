#include <map>
#include <multireach/images_t.hpp>
#include <optional>

#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "runtime/message_schema.hpp"
#include "runtime/node.hpp"
#include "runtime/progress.hpp"
#include "tools/log/export.hpp"
#include "tools/log/log_edit.hpp"
#include "tools/log/mcap_writer.hpp"

namespace multireach {
namespace {

using json = nlohmann::ordered_json;

json object_schema(const std::string& title, const json& properties) {
  return {{"title", title}, {"type", "object"}, {"properties", properties}};
}

json time_schema() {
  return object_schema("time", {{"sec", {{"type", "integer"}, {"minimum", 0}}},
                                {"nsec", {{"type", "integer"}, {"minimum", 0}, {"maximum", 999999999}}}});
}

const json kBytes = {{"type", "string"}, {"contentEncoding", "base64"}};
const json kText = {{"type", "string"}};
const json kInteger = {{"type", "integer"}};

/// The schemas of foxglove.CompressedImage and foxglove.RawImage that Foxglove and Lichtblick expect.
json compressed_image_schema() {
  return object_schema("foxglove.CompressedImage",
                       {{"timestamp", time_schema()}, {"frame_id", kText}, {"data", kBytes}, {"format", kText}});
}
json raw_image_schema() {
  return object_schema("foxglove.RawImage", {{"timestamp", time_schema()},
                                             {"frame_id", kText},
                                             {"width", kInteger},
                                             {"height", kInteger},
                                             {"encoding", kText},
                                             {"step", kInteger},
                                             {"data", kBytes}});
}

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

class Exporter {
 public:
  explicit Exporter(const std::string& file) : writer_(file) {}

  void add(const LogEvent& event) {
    const MessageSchema* schema = MessageSchemas::project().of(event.data);
    if (!schema) return;
    if (schema->name == "images_t") return add_images(event);
    const auto message = json_of(*schema, event.data);
    if (!message) return;
    write(
        std::string(event.channel), "multireach." + schema->name, [&] { return json_schema_of(*schema); }, event,
        *message);
  }
  int64_t close() {
    writer_.close();
    return written_;
  }

 private:
  void add_images(const LogEvent& event) {
    const auto images = decode<images_t>(event.data);
    if (!images) return;
    for (size_t i = 0; i < images->images.size(); ++i) {
      const image_t& image = images->images[i];
      const std::string side = images->image_types[i] == images_t::LEFT    ? "left"
                               : images->image_types[i] == images_t::RIGHT ? "right"
                                                                           : std::to_string(images->image_types[i]);
      const std::string topic = std::string(event.channel) + "/" + side;
      json message = {{"timestamp", {{"sec", image.utime / 1000000}, {"nsec", image.utime % 1000000 * 1000}}},
                      {"frame_id", side}};
      if (image.pixelformat == image_t::PIXEL_FORMAT_MJPEG) {
        message["data"] = base64(image.data);
        message["format"] = "jpeg";
        write(topic, "foxglove.CompressedImage", compressed_image_schema, event, message);
      } else if (const auto encoding = encoding_of(image.pixelformat)) {
        message["width"] = image.width;
        message["height"] = image.height;
        message["encoding"] = *encoding;
        message["step"] = image.row_stride;
        message["data"] = base64(image.data);
        write(topic, "foxglove.RawImage", raw_image_schema, event, message);
      }
    }
  }

  template <class MakeSchema>
  void write(const std::string& topic, const std::string& schema_name, const MakeSchema& make_schema,
             const LogEvent& event, const json& message) {
    auto schema = schemas_.find(schema_name);
    if (schema == schemas_.end()) {
      schema = schemas_.emplace(schema_name, writer_.add_schema(schema_name, make_schema().dump())).first;
    }
    auto channel = channels_.find({topic, schema->second});
    if (channel == channels_.end()) {
      channel = channels_.emplace(std::pair(topic, schema->second), writer_.add_channel(schema->second, topic)).first;
    }
    const uint64_t time = plausible_utime(event.utime) ? static_cast<uint64_t>(event.utime) * 1000 : 0;
    const auto text = message.dump(-1, ' ', false, json::error_handler_t::replace);
    writer_.write(channel->second, static_cast<uint32_t>(event.number), time, time, text);
    ++written_;
  }

  McapWriter writer_;
  std::map<std::string, uint16_t> schemas_;
  std::map<std::pair<std::string, uint16_t>, uint16_t> channels_;
  int64_t written_ = 0;
};

}  // namespace

int64_t export_mcap(const std::string& log, const std::string& file, const ChannelPatterns& patterns) {
  LogReader reader(log);
  Exporter exporter(file);
  Progress progress;
  while (const auto event = reader.next()) {
    progress.show(static_cast<double>(reader.position()) / static_cast<double>(reader.size()));
    if (matches_any(patterns, event->channel)) exporter.add(*event);
  }
  report_damage(log, reader);
  return exporter.close();
}

}  // namespace multireach
