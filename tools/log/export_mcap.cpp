#include <map>
#include <multireach/images_t.hpp>
#include <optional>

#include "runtime/json_text.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "runtime/message_schema.hpp"
#include "runtime/node.hpp"
#include "runtime/progress.hpp"
#include "tools/foxglove/schemas.hpp"
#include "tools/log/export.hpp"
#include "tools/log/log_edit.hpp"
#include "tools/log/mcap_writer.hpp"

namespace multireach {
namespace {

using json = nlohmann::ordered_json;

class Exporter {
 public:
  Exporter(const std::string& file, FoxgloveScene* scene) : writer_(file), scene_(scene) {}

  void add(const LogEvent& event) {
    if (scene_) {
      for (const FoxgloveMessage& message : scene_->messages(event.channel, event.data, event.utime))
        write(message, event);
    }
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
      if (const auto image = foxglove_image(std::string(event.channel), *images, i)) write(*image, event);
    }
  }

  void write(const FoxgloveMessage& message, const LogEvent& event) {
    write(
        message.topic, message.schema, [&] { return foxglove_schema(message.schema); }, event, message.message);
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
    const std::string text = json_text(message);
    writer_.write(channel->second, static_cast<uint32_t>(event.number), time, time, text);
    ++written_;
  }

  McapWriter writer_;
  FoxgloveScene* scene_;
  std::map<std::string, uint16_t> schemas_;
  std::map<std::pair<std::string, uint16_t>, uint16_t> channels_;
  int64_t written_ = 0;
};

}  // namespace

int64_t export_mcap(const std::string& log, const std::string& file, const ChannelPatterns& patterns,
                    FoxgloveScene* scene) {
  LogReader reader(log);
  Exporter exporter(file, scene);
  Progress progress;
  while (const auto event = reader.next()) {
    progress.show(static_cast<double>(reader.position()) / static_cast<double>(reader.size()));
    if (matches_any(patterns, event->channel)) exporter.add(*event);
  }
  report_damage(log, reader);
  return exporter.close();
}

}  // namespace multireach
