#include "robot_bridge/drivers/dynamixel.hpp"

#include <algorithm>
#include <array>

namespace multireach::drivers::dynamixel {
namespace {

constexpr std::array<uint8_t, 4> kHeader{0xFF, 0xFF, 0xFD, 0x00};
constexpr size_t kBeforeInstruction = 7;  // header, id, length
constexpr size_t kShortest = 3;           // of the length field: instruction and CRC
constexpr size_t kLongest = 1024;

}  // namespace

uint16_t crc(std::span<const uint8_t> bytes) {
  uint16_t value = 0;
  for (const uint8_t byte : bytes) {
    value = static_cast<uint16_t>(value ^ byte << 8);
    for (int bit = 0; bit < 8; ++bit) value = static_cast<uint16_t>(value & 0x8000 ? value << 1 ^ 0x8005 : value << 1);
  }
  return value;
}

void put(std::vector<uint8_t>& bytes, int64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<uint8_t>(value >> 8 * i));
}

int32_t get(std::span<const uint8_t> bytes, size_t at, int size) {
  uint32_t value = 0;
  for (int i = 0; i < size; ++i) value |= static_cast<uint32_t>(bytes[at + static_cast<size_t>(i)]) << 8 * i;
  if (size == 2) return static_cast<int16_t>(value);
  return size == 1 ? static_cast<int32_t>(value) : static_cast<int32_t>(value);
}

std::vector<uint8_t> encode(const Packet& packet) {
  std::vector<uint8_t> body{packet.instruction};
  // FF FF FD inside a packet is followed by one more FD, so that it is no header.
  for (const uint8_t byte : packet.parameters) {
    body.push_back(byte);
    const size_t n = body.size();
    if (n >= 3 && body[n - 1] == 0xFD && body[n - 2] == 0xFF && body[n - 3] == 0xFF) body.push_back(0xFD);
  }
  std::vector<uint8_t> bytes(kHeader.begin(), kHeader.end());
  bytes.push_back(packet.id);
  put(bytes, static_cast<int64_t>(body.size() + 2), 2);
  bytes.insert(bytes.end(), body.begin(), body.end());
  put(bytes, crc(bytes), 2);
  return bytes;
}

std::optional<Packet> Stream::next() {
  for (;;) {
    const auto begin = std::search(buffer_.begin(), buffer_.end(), kHeader.begin(), kHeader.end());
    const auto keep = static_cast<std::ptrdiff_t>(kHeader.size()) - 1;
    if (begin == buffer_.end()) {
      if (buffer_.size() > kHeader.size()) buffer_.erase(buffer_.begin(), buffer_.end() - keep);
      return std::nullopt;
    }
    buffer_.erase(buffer_.begin(), begin);
    if (buffer_.size() < kBeforeInstruction) return std::nullopt;
    const size_t length = static_cast<uint16_t>(get(buffer_, 5, 2));
    const size_t size = kBeforeInstruction + length;
    const bool possible = length >= kShortest && length <= kLongest;
    if (possible && buffer_.size() < size) return std::nullopt;
    const bool valid =
        possible && crc(std::span(buffer_).first(size - 2)) == static_cast<uint16_t>(get(buffer_, size - 2, 2));
    if (!valid) {
      ++corrupt_;
      buffer_.erase(buffer_.begin());  // the next packet may begin inside this one
      continue;
    }
    Packet packet{buffer_[4], buffer_[kBeforeInstruction], {}};
    std::vector<uint8_t>& parameters = packet.parameters;
    for (size_t i = kBeforeInstruction + 1; i < size - 2; ++i) {
      const bool stuffed = i >= kBeforeInstruction + 3 && buffer_[i] == 0xFD && buffer_[i - 1] == 0xFD &&
                           buffer_[i - 2] == 0xFF && buffer_[i - 3] == 0xFF;
      if (!stuffed) parameters.push_back(buffer_[i]);
    }
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(size));
    return packet;
  }
}

}  // namespace multireach::drivers::dynamixel
