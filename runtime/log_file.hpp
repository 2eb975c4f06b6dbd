#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/files.hpp"
#include "runtime/mapped_file.hpp"

namespace multireach {

/// One event of a log. Its views are valid as long as the reader.
struct LogEvent {
  int64_t number = 0;
  int64_t utime = 0;  ///< time of receipt by the logger, wall clock, microseconds
  std::string_view channel;
  std::span<const uint8_t> data;      ///< the message, without the trailer of a signed one
  std::span<const uint8_t> recorded;  ///< as it was sent
};

/// Reads an lcm-logger file by mapping it into memory. An event is EDA1DA01, int64 number, int64 time, int32 channel
/// length, int32 data length, channel, data, all big-endian. The reader skips damaged bytes to the next valid event and
/// counts them. Never crashes on a damaged file.
class LogReader {
 public:
  /// Throws InputError when the file cannot be read or holds no event (in its first 256 MB).
  explicit LogReader(const std::string& path);

  std::optional<LogEvent> next();
  void rewind();
  size_t size() const { return bytes_.size(); }
  size_t position() const { return position_; }
  /// Bytes skipped as damaged since the start, and the number of damaged stretches.
  size_t damaged_bytes() const { return damaged_bytes_; }
  size_t damaged_places() const { return damaged_places_; }

 private:
  std::optional<LogEvent> event_at(size_t position) const;
  static size_t end_of(size_t position, const LogEvent& event);
  /// Position of the next event's sync mark EDA1DA01; the end of the file when there is none.
  size_t next_mark(size_t from) const;
  /// Whether a sync mark, or the end of the file, is at `end`.
  bool followed(size_t end) const;
  /// Whether the length field of an apparently valid event is damaged, judged by whether the next event starts where
  /// the length says.
  bool has_wrong_length(size_t position, const LogEvent& event) const;

  MappedFile file_;
  std::span<const uint8_t> bytes_;
  size_t position_ = 0;
  size_t damaged_bytes_ = 0, damaged_places_ = 0;
};

/// Writes a file that lcm-logplayer plays. Throws as OutputFile does.
class LogWriter {
 public:
  explicit LogWriter(const std::string& path);
  /// Events are numbered from 0.
  void write(int64_t utime, std::string_view channel, std::span<const uint8_t> data);
  /// Completes the file under its final name. Without `close`, no file is left.
  void close();

 private:
  void flush();

  OutputFile file_;
  std::vector<uint8_t> waiting_;
  int64_t number_ = 0;
};

}  // namespace multireach
