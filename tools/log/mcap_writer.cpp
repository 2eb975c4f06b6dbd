#include "tools/log/mcap_writer.hpp"

#include <algorithm>

namespace multireach {
namespace {

constexpr size_t kChunkSize = 1 << 20;
constexpr std::string_view kMagic = "\x89MCAP0\r\n";

/// Record opcodes (mcap.dev/spec, "Records").
enum class Record : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kDataEnd = 0x0F,
};

/// The content of a record: little-endian integers, and strings preceded by their lengths.
class Fields {
 public:
  template <class Integer>
  Fields& number(Integer value) {
    for (size_t i = 0; i < sizeof(Integer); ++i) {
      bytes.push_back(static_cast<char>(static_cast<uint64_t>(value) >> (8 * i) & 0xff));
    }
    return *this;
  }
  Fields& text(std::string_view value) {
    number(static_cast<uint32_t>(value.size()));
    bytes += value;
    return *this;
  }
  std::string bytes;
};

std::string record(Record opcode, std::string_view contents) {
  Fields fields;
  fields.number(static_cast<uint8_t>(opcode)).number(static_cast<uint64_t>(contents.size()));
  fields.bytes += contents;
  return std::move(fields.bytes);
}

}  // namespace

McapWriter::McapWriter(const std::string& path) : file_(path) {
  put(kMagic);
  put(record(Record::kHeader, Fields().text("").text("multireach").bytes));
}

void McapWriter::put(std::string_view bytes) {
  file_.write({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
  position_ += bytes.size();
}

uint16_t McapWriter::add_schema(const std::string& name, const std::string& json_schema) {
  ++schemas_;
  const std::string bytes =
      record(Record::kSchema, Fields().number(schemas_).text(name).text("jsonschema").text(json_schema).bytes);
  definitions_ += bytes;
  chunk_ += bytes;
  return schemas_;
}

uint16_t McapWriter::add_channel(uint16_t schema, const std::string& topic) {
  const uint16_t channel = channels_++;
  const std::string bytes = record(
      Record::kChannel, Fields().number(channel).number(schema).text(topic).text("json").number(uint32_t{0}).bytes);
  definitions_ += bytes;
  chunk_ += bytes;
  return channel;
}

void McapWriter::write(uint16_t channel, uint32_t sequence, uint64_t log_time_ns, uint64_t publish_time_ns,
                       std::string_view data) {
  if (chunk_messages_.empty()) chunk_begin_ns_ = chunk_end_ns_ = log_time_ns;
  chunk_begin_ns_ = std::min(chunk_begin_ns_, log_time_ns);
  chunk_end_ns_ = std::max(chunk_end_ns_, log_time_ns);
  begin_ns_ = messages_ == 0 ? log_time_ns : std::min(begin_ns_, log_time_ns);
  end_ns_ = std::max(end_ns_, log_time_ns);
  ++messages_;
  ++counts_[channel];
  chunk_messages_[channel].emplace_back(log_time_ns, chunk_.size());
  Fields fields;
  fields.number(channel).number(sequence).number(log_time_ns).number(publish_time_ns);
  fields.bytes += data;
  chunk_ += record(Record::kMessage, fields.bytes);
  if (chunk_.size() >= kChunkSize) end_chunk();
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  ChunkIndex index{.begin_ns = chunk_begin_ns_,
                   .end_ns = chunk_end_ns_,
                   .offset = position_,
                   .length = 0,
                   .index_length = 0,
                   .size = chunk_.size(),
                   .message_indexes = {}};
  Fields fields;
  // A checksum of 0 means that there is none.
  fields.number(chunk_begin_ns_).number(chunk_end_ns_).number(static_cast<uint64_t>(chunk_.size())).number(uint32_t{0});
  fields.text("").number(static_cast<uint64_t>(chunk_.size()));
  fields.bytes += chunk_;
  put(record(Record::kChunk, fields.bytes));
  index.length = position_ - index.offset;
  const uint64_t indexes = position_;
  for (const auto& [channel, messages] : chunk_messages_) {
    index.message_indexes[channel] = position_;
    Fields list;
    for (const auto& [time, offset] : messages) list.number(time).number(offset);
    put(record(Record::kMessageIndex, Fields().number(channel).text(list.bytes).bytes));
  }
  index.index_length = position_ - indexes;
  chunks_.push_back(std::move(index));
  chunk_.clear();
  chunk_messages_.clear();
}

void McapWriter::close() {
  end_chunk();
  put(record(Record::kDataEnd, Fields().number(uint32_t{0}).bytes));
  const uint64_t summary = position_;
  put(definitions_);
  for (const ChunkIndex& chunk : chunks_) {
    Fields offsets;
    for (const auto& [channel, offset] : chunk.message_indexes) offsets.number(channel).number(offset);
    Fields fields;
    fields.number(chunk.begin_ns).number(chunk.end_ns).number(chunk.offset).number(chunk.length);
    fields.text(offsets.bytes).number(chunk.index_length).text("").number(chunk.size).number(chunk.size);
    put(record(Record::kChunkIndex, fields.bytes));
  }
  Fields counts;
  for (const auto& [channel, count] : counts_) counts.number(channel).number(count);
  Fields statistics;
  statistics.number(messages_).number(schemas_).number(static_cast<uint32_t>(channels_)).number(uint32_t{0});
  statistics.number(uint32_t{0}).number(static_cast<uint32_t>(chunks_.size())).number(begin_ns_).number(end_ns_);
  statistics.text(counts.bytes);
  put(record(Record::kStatistics, statistics.bytes));
  put(record(Record::kFooter, Fields().number(summary).number(uint64_t{0}).number(uint32_t{0}).bytes));
  put(kMagic);
  file_.finish();
}

}  // namespace multireach
