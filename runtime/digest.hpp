#pragma once

#include <cstdint>
#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

namespace multireach {

/// XXH3 digest (64 bits) of `bytes`. It identifies a message by its content, independent of the sender.
int64_t digest_of(std::span<const uint8_t> bytes);
int64_t digest_of(std::string_view text);
/// Digest of the numbers' big-endian bytes; used to chain digests.
int64_t digest_of(std::initializer_list<int64_t> numbers);

/// Writes the digest of all preceding bytes into `check`, the last field of the message.
void set_checksum(std::vector<uint8_t>& message);
/// Whether the last eight bytes are the digest of the bytes before them.
[[nodiscard]] bool checksum_matches(std::span<const uint8_t> message);

}  // namespace multireach
