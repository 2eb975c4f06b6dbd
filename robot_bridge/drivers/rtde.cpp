#include "robot_bridge/drivers/rtde.hpp"

#include <bit>

namespace multireach::drivers::rtde {
namespace {

constexpr size_t kHeader = 3;

size_t length_of(const std::vector<uint8_t>& buffer) {
  return static_cast<size_t>(buffer[0]) << 8 | buffer[1];
}

}  // namespace

Writer& Writer::big_endian(uint64_t value, int size) {
  for (int shift = 8 * (size - 1); shift >= 0; shift -= 8) bytes_.push_back(static_cast<uint8_t>(value >> shift));
  return *this;
}
Writer& Writer::u8(uint8_t value) {
  return big_endian(value, 1);
}
Writer& Writer::u16(uint16_t value) {
  return big_endian(value, 2);
}
Writer& Writer::i32(int32_t value) {
  return big_endian(static_cast<uint32_t>(value), 4);
}
Writer& Writer::real(double value) {
  return big_endian(std::bit_cast<uint64_t>(value), 8);
}
Writer& Writer::text(std::string_view value) {
  bytes_.insert(bytes_.end(), value.begin(), value.end());
  return *this;
}

uint64_t Reader::big_endian(size_t size) {
  if (bytes_.size() < size) {
    short_ = true;
    return 0;
  }
  uint64_t value = 0;
  for (size_t i = 0; i < size; ++i) value = value << 8 | bytes_[i];
  bytes_ = bytes_.subspan(size);
  return value;
}

double Reader::real() {
  return std::bit_cast<double>(big_endian(8));
}

std::string Reader::rest() {
  std::string text(bytes_.begin(), bytes_.end());
  bytes_ = {};
  return text;
}

std::vector<uint8_t> encode(Type type, std::span<const uint8_t> payload) {
  std::vector<uint8_t> bytes =
      Writer().u16(static_cast<uint16_t>(kHeader + payload.size())).u8(static_cast<uint8_t>(type)).bytes();
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

std::vector<uint8_t> request_version() {
  return encode(Type::kVersion, Writer().u16(2).bytes());
}

std::vector<uint8_t> setup_outputs(double rate_hz, std::string_view names) {
  return encode(Type::kSetupOutputs, Writer().real(rate_hz).text(names).bytes());
}

std::vector<uint8_t> setup_inputs(std::string_view names) {
  return encode(Type::kSetupInputs, Writer().text(names).bytes());
}

std::vector<uint8_t> start() {
  return encode(Type::kStart, {});
}

bool Stream::broken() const {
  return buffer_.size() >= 2 && length_of(buffer_) < kHeader;
}

std::optional<Package> Stream::next() {
  if (buffer_.size() < kHeader || broken() || buffer_.size() < length_of(buffer_)) return std::nullopt;
  const auto end = buffer_.begin() + static_cast<std::ptrdiff_t>(length_of(buffer_));
  Package package{static_cast<Type>(buffer_[2]), {buffer_.begin() + kHeader, end}};
  buffer_.erase(buffer_.begin(), end);
  return package;
}

}  // namespace multireach::drivers::rtde
