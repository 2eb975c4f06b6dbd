#include "tools/log/import/ros_recording.hpp"

#include <algorithm>

#include "tools/log/import/chunk.hpp"

namespace multireach {

RosRecording::RosRecording(const ImportOptions& options)
    : options_(options), file_(options.input), store_(options.jpeg_quality) {
  chunks_.push_back({.name = path(), .compression = "", .data = file(), .offset = 0, .size = file().size()});
}

void RosRecording::add_topic(uint32_t id, Topic topic) {
  topics_.insert_or_assign(id, std::move(topic));
}

ByteReader RosRecording::add_chunk(Chunk chunk) {
  if (chunk.compression.empty() && chunk.size != chunk.data.size())
    throw InputError(
        fmt::format("{}: has {} bytes; expected the {} that it states", chunk.name, chunk.data.size(), chunk.size));
  const bool compressed = !chunk.compression.empty();
  // Bytes that are not compressed are bytes of the file, and errors give their places in it.
  const std::string name = compressed ? chunk.name + ", decompressed" : path();
  const uint64_t offset = compressed ? 0 : chunk.offset;
  chunks_.push_back(std::move(chunk));
  return {name, bytes_of(chunks_.size() - 1), offset};
}

std::span<const uint8_t> RosRecording::bytes_of(size_t number) {
  const Chunk& chunk = chunks_[number];
  if (chunk.compression.empty()) return chunk.data;
  if (cache_[0].chunk != number) {
    std::swap(cache_[0], cache_[1]);
    if (cache_[0].chunk != number) {
      cache_[0] = {};
      cache_[0] = {number, decompressed(chunk.compression, chunk.data, chunk.size, chunk.name)};
    }
  }
  return cache_[0].bytes;
}

std::optional<Side> RosRecording::side_of(const Topic& topic) const {
  if (topic.name == options_.left) return Side::kLeft;
  if (topic.name == options_.right) return Side::kRight;
  return std::nullopt;
}

void RosRecording::add_message(uint32_t id, ByteReader message, bool in_file) {
  const auto found = topics_.find(id);
  if (found == topics_.end())
    message.fail(fmt::format("a message is of the topic number {}, which is not declared before it", id));
  Topic& topic = found->second;
  const auto side = side_of(topic);
  if (!side || !ros_image_type(topic.type)) return;
  const size_t chunk = in_file ? 0 : chunks_.size() - 1;
  const bool file_offsets = in_file || chunks_[chunk].compression.empty();
  const size_t offset = message.position() - (file_offsets && !in_file ? chunks_[chunk].offset : 0);
  const int64_t utime = ros_stamp(message, topic.encoding);
  images_.push_back({utime, *side, messages_.size()});
  messages_.push_back({chunk, offset, message.left(), &topic, utime});
}

std::string RosRecording::image_topics() const {
  std::string list;
  for (const auto& [id, topic] : topics_) {
    if (ros_image_type(topic.type)) list += (list.empty() ? "" : ", ") + topic.name;
  }
  return list.empty() ? "it has no topic of images (sensor_msgs/Image or CompressedImage)"
                      : "its topics with images are " + list;
}

void RosRecording::check_topics() const {
  for (const auto& [name, option] : {std::pair(options_.left, "--left"), {options_.right, "--right"}}) {
    if (name.empty()) throw InputError(path() + ": " + option + " is missing; expected a topic; " + image_topics());
    const auto found = std::ranges::find(topics_, name, [](const auto& entry) { return entry.second.name; });
    if (found == topics_.end())
      throw InputError(path() + ": has no topic '" + name + "' (" + option + "); " + image_topics());
    if (!ros_image_type(found->second.type))
      throw InputError(path() + ": the topic '" + name + "' (" + option + ") is of type '" + found->second.type +
                       "'; " + image_topics());
  }
  if (options_.left == options_.right)
    throw InputError(path() + ": --left and --right are the same topic; expected two; " + image_topics());
}

std::vector<ListedImage> RosRecording::list(const Progress& progress) {
  scan(progress);
  check_topics();
  return images_;
}

Frame RosRecording::read(const ListedImage& image) {
  const Message& message = messages_[image.number];
  const Chunk& chunk = chunks_[message.chunk];
  const bool compressed = !chunk.compression.empty();
  const ByteReader bytes(compressed ? chunk.name + ", decompressed" : path(),
                         bytes_of(message.chunk).subspan(message.offset, message.size),
                         message.offset + (compressed ? 0 : chunk.offset));
  return ros_frame(bytes, message.topic->encoding, *ros_image_type(message.topic->type), store_);
}

}  // namespace multireach
