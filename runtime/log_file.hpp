#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/files.hpp"

namespace multireach {

/// One event of a log. The views live as long as the reader.
struct LogEvent {
  int64_t number = 0;
  int64_t utime = 0;  ///< when the logger received it, wall clock, microseconds
  std::string_view channel;
  std::span<const uint8_t> data;
};

/// Reads a file of lcm-logger by mapping it into memory. An event is EDA1DA01, int64 number, int64 time, int32 channel
/// length, int32 data length, channel, data, all big-endian. Where the bytes are no event, the reader goes on at the
/// next place where they are one, and counts what it left out. Never crashes on a damaged file.
class LogReader {
 public:
  /// Throws InputError when the file cannot be read or holds not a single event.
  explicit LogReader(const std::string& path);
  ~LogReader();
  LogReader(const LogReader&) = delete;
  LogReader& operator=(const LogReader&) = delete;

  std::optional<LogEvent> next();
  void rewind();
  size_t size() const { return bytes_.size(); }
  size_t position() const { return position_; }
  /// Bytes left out since the start because they were no event, in how many places.
  size_t damaged_bytes() const { return damaged_bytes_; }
  size_t damaged_places() const { return damaged_places_; }

 private:
  std::optional<LogEvent> event_at(size_t position) const;
  static size_t end_of(size_t position, const LogEvent& event);
  /// Where the next mark of an event is; the end where there is none.
  size_t next_mark(size_t from) const;
  /// Whether another event, or the end of the file, is at `end`.
  bool followed(size_t end) const;
  /// Whether the length of an event that looks whole is damaged: told by what is where the next one should be.
  bool has_wrong_length(size_t position, const LogEvent& event) const;

  std::span<const uint8_t> bytes_;
  size_t position_ = 0;
  size_t damaged_bytes_ = 0, damaged_places_ = 0;
};

/// Writes a file that lcm-logplayer plays. Throws InputError when it cannot be written.
class LogWriter {
 public:
  explicit LogWriter(const std::string& path);
  /// Events are numbered from 0.
  void write(int64_t utime, std::string_view channel, std::span<const uint8_t> data);
  /// Makes it the file of that name; a log that was begun and not closed leaves none.
  void close();

 private:
  void flush();

  OutputFile file_;
  std::vector<uint8_t> waiting_;
  int64_t number_ = 0;
};

}  // namespace multireach
