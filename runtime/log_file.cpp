#include "runtime/log_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace multireach {
namespace {

constexpr uint32_t kSync = 0xEDA1DA01;
constexpr size_t kHeader = 28;
constexpr size_t kBuffer = 1 << 18;
constexpr uint32_t kLongestChannel = 63;  // LCM_MAX_CHANNEL_NAME_LENGTH

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

}  // namespace

LogReader::LogReader(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) throw InputError(path + ": cannot be opened (" + std::strerror(errno) + ")");
  struct stat status = {};
  if (fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(file);
    throw InputError(path + ": is not a file that can be read as a log");
  }
  const auto size = static_cast<size_t>(status.st_size);
  if (size > 0) {
    void* map = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
    if (map != MAP_FAILED) bytes_ = {static_cast<const uint8_t*>(map), size};
  }
  ::close(file);
  const bool any = next().has_value();
  rewind();
  if (!any) {
    if (!bytes_.empty()) munmap(const_cast<uint8_t*>(bytes_.data()), bytes_.size());
    throw InputError(path + ": holds no event of an LCM log");
  }
}

LogReader::~LogReader() {
  munmap(const_cast<uint8_t*>(bytes_.data()), bytes_.size());
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
  if (channel_size < 1 || channel_size > kLongestChannel || channel_size > left || data_size > left - channel_size) {
    return std::nullopt;
  }
  LogEvent event;
  event.number = static_cast<int64_t>(read_big_endian<uint64_t>(header + 4));
  event.utime = static_cast<int64_t>(read_big_endian<uint64_t>(header + 12));
  event.channel = {reinterpret_cast<const char*>(header + kHeader), channel_size};
  event.data = bytes_.subspan(position + kHeader + channel_size, data_size);
  return event;
}

std::optional<LogEvent> LogReader::next() {
  if (position_ >= bytes_.size()) return std::nullopt;
  auto event = event_at(position_);
  if (!event) {
    const size_t from = position_;
    static constexpr std::array<uint8_t, 4> kMark{0xED, 0xA1, 0xDA, 0x01};
    while (!event && position_ < bytes_.size()) {
      ++position_;
      const void* found = memmem(bytes_.data() + position_, bytes_.size() - position_, kMark.data(), kMark.size());
      position_ = found ? static_cast<size_t>(static_cast<const uint8_t*>(found) - bytes_.data()) : bytes_.size();
      event = event_at(position_);
    }
    damaged_bytes_ += position_ - from;
    ++damaged_places_;
  }
  if (event) position_ += kHeader + event->channel.size() + event->data.size();
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
