#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/files.hpp"

namespace multireach {

/// Writes an MCAP file (mcap.dev/spec, version 0) in uncompressed chunks, with the indexes that readers use for
/// seeking. Memory is constant except for the index of chunks. Throws as OutputFile does.
class McapWriter {
 public:
  explicit McapWriter(const std::string& path);

  /// Adds a schema in JSON Schema. Returns its number.
  uint16_t add_schema(const std::string& name, const std::string& json_schema);
  /// Adds a channel of JSON messages. Returns its number.
  uint16_t add_channel(uint16_t schema, const std::string& topic);
  void write(uint16_t channel, uint32_t sequence, uint64_t log_time_ns, uint64_t publish_time_ns,
             std::string_view data);
  void close();

 private:
  struct ChunkIndex {
    uint64_t begin_ns, end_ns, offset, length, index_length, size;
    std::map<uint16_t, uint64_t> message_indexes;
  };

  void put(std::string_view bytes);
  void end_chunk();

  OutputFile file_;
  uint64_t position_ = 0;
  std::string definitions_;  // schemas and channels, repeated in the summary section
  std::string chunk_;
  uint64_t chunk_begin_ns_ = 0, chunk_end_ns_ = 0;
  std::map<uint16_t, std::vector<std::pair<uint64_t, uint64_t>>> chunk_messages_;
  std::vector<ChunkIndex> chunks_;
  std::map<uint16_t, uint64_t> counts_;
  uint64_t begin_ns_ = 0, end_ns_ = 0, messages_ = 0;
  uint16_t schemas_ = 0, channels_ = 0;
};

}  // namespace multireach
