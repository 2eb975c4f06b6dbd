#include "runtime/digest.hpp"

#include <xxhash.h>

#include <cstring>

namespace multireach {
namespace {

constexpr size_t kCheck = 8;

}  // namespace

int64_t digest_of(std::span<const uint8_t> bytes) {
  return static_cast<int64_t>(XXH3_64bits(bytes.data(), bytes.size()));
}

int64_t digest_of(std::string_view text) {
  return static_cast<int64_t>(XXH3_64bits(text.data(), text.size()));
}

int64_t digest_of(std::initializer_list<int64_t> numbers) {
  std::vector<uint8_t> bytes;
  bytes.reserve(8 * numbers.size());
  for (const int64_t number : numbers) {
    for (int shift = 56; shift >= 0; shift -= 8) {
      bytes.push_back(static_cast<uint8_t>(static_cast<uint64_t>(number) >> shift));
    }
  }
  return digest_of(bytes);
}

void set_checksum(std::vector<uint8_t>& message) {
  if (message.size() < kCheck) return;
  const size_t before = message.size() - kCheck;
  XXH64_canonical_t check;
  XXH64_canonicalFromHash(&check, XXH3_64bits(message.data(), before));
  std::memcpy(message.data() + before, check.digest, kCheck);
}

bool checksum_matches(std::span<const uint8_t> message) {
  if (message.size() < kCheck) return false;
  const size_t before = message.size() - kCheck;
  XXH64_canonical_t check;
  std::memcpy(check.digest, message.data() + before, kCheck);
  return XXH64_hashFromCanonical(&check) == XXH3_64bits(message.data(), before);
}

}  // namespace multireach
