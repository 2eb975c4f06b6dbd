#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace multireach {

/// What a message's first eight bytes, LCM's fingerprint of its type, tell about it.
struct MessageType {
  std::string name;  ///< as "target_t"
  /// Whether the bytes are one well-formed message of the type.
  bool (*well_formed)(std::span<const uint8_t> bytes);
  /// The publisher's count of its messages; nothing where the type has none, or the bytes are no message.
  std::optional<int64_t> (*sequence)(std::span<const uint8_t> bytes);
};

/// The type of a message, where it is one of the project's; else null. Lives as long as the program.
const MessageType* type_of(std::span<const uint8_t> bytes);

}  // namespace multireach
