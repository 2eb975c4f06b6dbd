#include "robot_bridge/drivers/feetech.hpp"

#include <algorithm>
#include <cstdlib>
#include <numeric>

namespace multireach::drivers::feetech {
namespace {

constexpr size_t kBeforeLength = 4;  // FF FF, id, length
constexpr uint16_t kSign = 0x8000;

uint8_t checksum(std::span<const uint8_t> bytes) {
  return static_cast<uint8_t>(~std::accumulate(bytes.begin(), bytes.end(), 0U));
}

}  // namespace

uint16_t sign_magnitude(int value) {
  return static_cast<uint16_t>(std::min(std::abs(value), 0x7FFF) | (value < 0 ? kSign : 0));
}

int from_sign_magnitude(uint16_t value) {
  const int magnitude = value & 0x7FFF;
  return value & kSign ? -magnitude : magnitude;
}

std::vector<uint8_t> encode(const Packet& packet) {
  std::vector<uint8_t> bytes(2, 0xFF);
  bytes.push_back(packet.id);
  bytes.push_back(static_cast<uint8_t>(packet.parameters.size() + 2));
  bytes.push_back(packet.instruction);
  for (const uint8_t parameter : packet.parameters) bytes.push_back(parameter);
  bytes.push_back(checksum(std::span(bytes).subspan(2)));
  return bytes;
}

std::optional<Packet> Stream::next() {
  for (;;) {
    while (buffer_.size() >= 2 && !(buffer_[0] == 0xFF && buffer_[1] == 0xFF)) buffer_.erase(buffer_.begin());
    if (buffer_.size() < kBeforeLength) return std::nullopt;
    const size_t length = buffer_[3], size = kBeforeLength + length;
    const bool possible = buffer_[2] != 0xFF && length >= 2;
    if (possible && buffer_.size() < size) return std::nullopt;
    if (!possible || checksum(std::span(buffer_).subspan(2, size - 3)) != buffer_[size - 1]) {
      corrupt_ += possible ? 1 : 0;
      buffer_.erase(buffer_.begin());
      continue;
    }
    const auto end = buffer_.begin() + static_cast<std::ptrdiff_t>(size);
    Packet packet{buffer_[2], buffer_[4], {buffer_.begin() + 5, end - 1}};
    buffer_.erase(buffer_.begin(), end);
    return packet;
  }
}

}  // namespace multireach::drivers::feetech
