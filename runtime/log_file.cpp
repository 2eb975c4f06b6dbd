#include "runtime/log_file.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "runtime/tagged_message.hpp"

namespace multireach {
namespace {

constexpr uint32_t kSync = 0xEDA1DA01;
constexpr size_t kHeader = 28;
constexpr size_t kBuffer = 1 << 18;
constexpr size_t kSearchedBegin = size_t{1} << 28;  // bytes in which a log must have an event
constexpr int kMaxMarks = 64;                       // sync marks examined to find out whether a length is damaged
constexpr uint32_t kMaxChannelName = 63;            // LCM_MAX_CHANNEL_NAME_LENGTH

template <class Integer>
Integer read_big_endian(const uint8_t* bytes) {
  Integer value = 0;
  for (size_t i = 0; i < sizeof(Integer); ++i) value = (value << 8) | bytes[i];
  return value;
}

template <class Integer>
void append_big_endian(std::vector<uint8_t>& to, Integer value) {
  std::array<uint8_t, sizeof(Integer)> bytes;
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<uint8_t>(value >> (8 * (bytes.size() - 1 - i)));
  to.insert(to.end(), bytes.begin(), bytes.end());
}

/// Whether the logger numbered `event` right after `before`. A damaged number may be the largest there is.
bool follows(const LogEvent& event, const LogEvent& before) {
  return static_cast<uint64_t>(event.number) == static_cast<uint64_t>(before.number) + 1;
}

}  // namespace

LogReader::LogReader(const std::string& path) : file_(path) {
  // A file that is no log must not be searched for an event for minutes.
  const std::span<const uint8_t> whole = file_.bytes();
  bytes_ = whole.first(std::min(whole.size(), kSearchedBegin));
  bool any = next_mark(0) < bytes_.size();
  bytes_ = whole;
  any = any && next().has_value();
  rewind();
  if (!any) {
    throw InputError(path + ": holds no event of an LCM log" +
                     (whole.size() > kSearchedBegin ? " in its first 256 MB" : std::string()));
  }
}

void LogReader::rewind() {
  position_ = damaged_bytes_ = damaged_places_ = 0;
}

std::optional<LogEvent> LogReader::event_at(size_t position) const {
  if (bytes_.size() - position < kHeader) return std::nullopt;
  const uint8_t* header = bytes_.data() + position;
  if (read_big_endian<uint32_t>(header) != kSync) return std::nullopt;
  const auto channel_size = read_big_endian<uint32_t>(header + 20), data_size = read_big_endian<uint32_t>(header + 24);
  const size_t left = bytes_.size() - position - kHeader;
  if (channel_size < 1 || channel_size > kMaxChannelName || channel_size > left || data_size > left - channel_size) {
    return std::nullopt;
  }
  LogEvent event;
  event.number = static_cast<int64_t>(read_big_endian<uint64_t>(header + 4));
  event.utime = static_cast<int64_t>(read_big_endian<uint64_t>(header + 12));
  event.channel = {reinterpret_cast<const char*>(header + kHeader), channel_size};
  event.recorded = bytes_.subspan(position + kHeader + channel_size, data_size);
  event.data = without_trailer(event.recorded);
  return event;
}

size_t LogReader::next_mark(size_t from) const {
  static constexpr std::array<uint8_t, 4> kMark{0xED, 0xA1, 0xDA, 0x01};
  if (from >= bytes_.size()) return bytes_.size();
  const void* found = memmem(bytes_.data() + from, bytes_.size() - from, kMark.data(), kMark.size());
  return found ? static_cast<size_t>(static_cast<const uint8_t*>(found) - bytes_.data()) : bytes_.size();
}

size_t LogReader::end_of(size_t position, const LogEvent& event) {
  return position + kHeader + event.channel.size() + event.recorded.size();
}

bool LogReader::followed(size_t end) const {
  return end == bytes_.size() || (bytes_.size() - end >= 4 && read_big_endian<uint32_t>(bytes_.data() + end) == kSync);
}

bool LogReader::has_wrong_length(size_t position, const LogEvent& event) const {
  const size_t end = end_of(position, event);
  const bool ends_well = followed(end);
  if (ends_well) {
    const auto next = event_at(end);
    if (next && follows(*next, event)) return false;
  }
  int marks = 0;
  for (size_t mark = next_mark(position + 4); mark < bytes_.size() && marks < kMaxMarks; mark = next_mark(mark + 4)) {
    ++marks;
    const auto other = event_at(mark);
    if (!other || !followed(end_of(mark, *other))) continue;
    // The length spans whole events, or ends before the event's own last bytes.
    const bool is_next = follows(*other, event);
    return ends_well ? mark < end && is_next : mark < end || is_next;
  }
  return false;
}

std::optional<LogEvent> LogReader::next() {
  if (position_ >= bytes_.size()) return std::nullopt;
  auto event = event_at(position_);
  if (event && has_wrong_length(position_, *event)) event.reset();
  if (!event) {
    const size_t from = position_;
    while (!event && position_ < bytes_.size()) {
      position_ = next_mark(position_ + 1);
      event = event_at(position_);
      if (event && has_wrong_length(position_, *event)) event.reset();
    }
    damaged_bytes_ += position_ - from;
    ++damaged_places_;
  }
  if (event) position_ = end_of(position_, *event);
  return event;
}

LogWriter::LogWriter(const std::string& path) : file_(path) {
  waiting_.reserve(kBuffer);
}

void LogWriter::write(int64_t utime, std::string_view channel, std::span<const uint8_t> data) {
  append_big_endian(waiting_, kSync);
  append_big_endian(waiting_, static_cast<uint64_t>(number_++));
  append_big_endian(waiting_, static_cast<uint64_t>(utime));
  append_big_endian(waiting_, static_cast<uint32_t>(channel.size()));
  append_big_endian(waiting_, static_cast<uint32_t>(data.size()));
  waiting_.insert(waiting_.end(), channel.begin(), channel.end());
  if (waiting_.size() + data.size() > kBuffer) flush();
  if (data.size() > kBuffer) {
    file_.write(data);
  } else {
    waiting_.insert(waiting_.end(), data.begin(), data.end());
  }
}

void LogWriter::flush() {
  file_.write(waiting_);
  waiting_.clear();
}

void LogWriter::close() {
  flush();
  file_.finish();
}

}  // namespace multireach
