#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace multireach {

/// Decodes `bytes` into `message`, whose memory is used again. Returns false, with any content left in `message`, when
/// they are not exactly one well-formed message of this type: wrong fingerprint, truncated, trailing bytes, or a count
/// that exceeds the bytes. Never throws and never allocates more than the bytes could fill (see lcmtypes/harden.cmake).
/// Bit errors inside a field go undetected: LCM has no checksum. An array whose count is 0 keeps its old elements: go
/// by the count.
template <class Message>
[[nodiscard]] bool decode_into(std::span<const uint8_t> bytes, Message& message) noexcept {
  if (bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max())) return false;
  try {
    const int size = static_cast<int>(bytes.size());
    return message.decode(bytes.data(), 0, size) == size;
  } catch (...) {
    return false;
  }
}

/// Like decode_into(); nothing where that returns false.
template <class Message>
[[nodiscard]] std::optional<Message> decode(std::span<const uint8_t> bytes) noexcept {
  std::optional<Message> message(std::in_place);
  if (!decode_into(bytes, *message)) message.reset();
  return message;
}

/// Encodes `message` into `bytes`, whose memory is used again. Returns false when a count disagrees with the size of
/// its vector.
template <class Message>
[[nodiscard]] bool encode_into(const Message& message, std::vector<uint8_t>& bytes) {
  const int size = message.getEncodedSize();
  if (size < 8) return false;
  bytes.resize(static_cast<size_t>(size));
  return message.encode(bytes.data(), 0, size) == size;
}

/// Like encode_into(); nothing where that returns false.
template <class Message>
[[nodiscard]] std::optional<std::vector<uint8_t>> encode(const Message& message) {
  std::optional<std::vector<uint8_t>> bytes(std::in_place);
  if (!encode_into(message, *bytes)) bytes.reset();
  return bytes;
}

}  // namespace multireach
