#pragma once

#include <cstdint>
#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

namespace multireach {

/// XXH3 (64 bits) of some bytes: names a message by what is in it, whoever sent it and however often.
int64_t digest_of(std::span<const uint8_t> bytes);
int64_t digest_of(std::string_view text);
/// Of numbers, in big-endian bytes: chains digests.
int64_t digest_of(std::initializer_list<int64_t> numbers);

/// For messages that end in a field `check`, the digest of all bytes before it: puts it in its place.
void seal(std::vector<uint8_t>& message);
/// Whether the last eight bytes are the digest of those before.
bool sealed(std::span<const uint8_t> message);

}  // namespace multireach
