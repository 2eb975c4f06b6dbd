#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace multireach {

/// Decodes `bytes`, or returns nothing when they are not exactly one well-formed message of this type: wrong
/// fingerprint, truncated, trailing bytes, or a count that exceeds the bytes. Never throws and never allocates more
/// than the bytes could fill (see lcmtypes/harden.cmake). Bit errors inside a field go undetected: LCM has no checksum.
template <class Message>
[[nodiscard]] std::optional<Message> decode(std::span<const uint8_t> bytes) noexcept {
  if (bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max())) return std::nullopt;
  try {
    std::optional<Message> message(std::in_place);
    const int size = static_cast<int>(bytes.size());
    if (message->decode(bytes.data(), 0, size) != size) return std::nullopt;
    return message;
  } catch (...) {
    return std::nullopt;
  }
}

/// Encodes `message`, or returns nothing when a count disagrees with the size of its vector.
template <class Message>
[[nodiscard]] std::optional<std::vector<uint8_t>> encode(const Message& message) {
  const int size = message.getEncodedSize();
  if (size < 8) return std::nullopt;
  std::vector<uint8_t> bytes(size);
  if (message.encode(bytes.data(), 0, size) != size) return std::nullopt;
  return bytes;
}

}  // namespace multireach
