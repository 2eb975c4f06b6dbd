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

void seal(std::vector<uint8_t>& message) {
  if (message.size() < kCheck) return;
  const size_t before = message.size() - kCheck;
  XXH64_canonical_t check;
  XXH64_canonicalFromHash(&check, XXH3_64bits(message.data(), before));
  std::memcpy(message.data() + before, check.digest, kCheck);
}

bool sealed(std::span<const uint8_t> message) {
  if (message.size() < kCheck) return false;
  const size_t before = message.size() - kCheck;
  XXH64_canonical_t check;
  std::memcpy(check.digest, message.data() + before, kCheck);
  return XXH64_hashFromCanonical(&check) == XXH3_64bits(message.data(), before);
}

}  // namespace multireach
