#include "tools/replay/message_difference.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/message_schema.hpp"

namespace multireach {
namespace {

std::string byte_at(std::span<const uint8_t> bytes, size_t at) {
  return at < bytes.size() ? fmt::format("0x{:02x}", bytes[at]) : "the message has ended";
}

MessageDifference byte_difference(const std::string& what, std::span<const uint8_t> first,
                                  std::span<const uint8_t> second) {
  const auto at = static_cast<size_t>(std::ranges::mismatch(first, second).in1 - first.begin());
  return {what + fmt::format("byte {}", at), byte_at(first, at), byte_at(second, at)};
}

}  // namespace

MessageDifference difference_of(std::span<const uint8_t> first, std::span<const uint8_t> second) {
  const MessageSchemas& schemas = MessageSchemas::project();
  const MessageSchema* schema = schemas.of(first);
  if (!schema || schema != schemas.of(second)) return byte_difference("", first, second);
  const auto a = leaves_of(*schema, first), b = leaves_of(*schema, second);
  if (!a || !b) return byte_difference("", first, second);
  for (size_t i = 0; i < std::min(a->size(), b->size()); ++i) {
    const MessageLeaf &left = (*a)[i], &right = (*b)[i];
    if (left.path == right.path && std::ranges::equal(left.bytes, right.bytes)) continue;
    if (left.path != right.path) return {left.path, left.text(), "there is '" + right.path + "' in its place"};
    const std::string one = left.text(), other = right.text();
    if (one != other) return {left.path, one, other};
    return byte_difference(left.path + ", ", left.bytes, right.bytes);
  }
  return byte_difference("", first, second);
}

}  // namespace multireach
