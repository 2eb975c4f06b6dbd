#pragma once

#include "runtime/message_schema.hpp"

namespace multireach {

template <class Integer>
Integer big_endian(std::span<const uint8_t> bytes) {
  uint64_t value = 0;
  for (size_t i = 0; i < sizeof(Integer); ++i) value = value << 8 | bytes[i];
  return static_cast<Integer>(value);
}

/// Reads a big-endian integer of a kind from kInt8 to kInt64.
inline int64_t integer_in(MessageSchema::Kind kind, std::span<const uint8_t> bytes) {
  switch (kind) {
    case MessageSchema::Kind::kInt8:
      return static_cast<int8_t>(bytes[0]);
    case MessageSchema::Kind::kInt16:
      return big_endian<int16_t>(bytes);
    case MessageSchema::Kind::kInt32:
      return big_endian<int32_t>(bytes);
    default:
      return big_endian<int64_t>(bytes);
  }
}

/// Walks through the bytes of a message by its schema and reports every value to a sink. Never reads beyond the bytes,
/// and the counts in a damaged message cannot make it loop longer than its size allows.
template <class Sink>
class MessageWalk {
 public:
  MessageWalk(std::span<const uint8_t> message, Sink& sink) : bytes_(message), sink_(sink) {}

  /// Reads the fingerprint and the fields; false when the message is not well-formed or has trailing bytes.
  bool parse(const MessageSchema& schema) {
    if (bytes_.size() < 8 || big_endian<int64_t>(bytes_) != schema.fingerprint) return false;
    at_ = 8;
    sink_.begin_struct(nullptr);
    if (!fields(schema)) return false;
    sink_.end_struct();
    return at_ == bytes_.size();
  }

 private:
  using Field = MessageSchema::Field;
  using Kind = MessageSchema::Kind;

  static size_t size_of(Kind kind) {
    switch (kind) {
      case Kind::kInt16:
        return 2;
      case Kind::kInt32:
      case Kind::kFloat:
        return 4;
      case Kind::kInt64:
      case Kind::kDouble:
        return 8;
      default:
        return 1;
    }
  }

  bool fields(const MessageSchema& schema) {
    std::vector<int64_t> counts(schema.fields.size(), -1);
    for (size_t i = 0; i < schema.fields.size(); ++i) {
      const Field& field = schema.fields[i];
      const size_t begin = at_;
      if (!dimension(field, counts, 0)) return false;
      if (field.dimensions.empty() && field.kind >= Kind::kInt8 && field.kind <= Kind::kInt64) {
        counts[i] = integer_in(field.kind, bytes_.subspan(begin));
      }
    }
    return true;
  }

  bool dimension(const Field& field, const std::vector<int64_t>& counts, size_t depth) {
    const bool plain = field.kind != Kind::kString && field.kind != Kind::kStruct;
    if (depth == field.dimensions.size()) return plain ? values(field, 1) : element(field);
    const MessageSchema::Dimension& dimension = field.dimensions[depth];
    const int64_t count =
        dimension.field < 0 ? static_cast<int64_t>(dimension.size) : counts[static_cast<size_t>(dimension.field)];
    // Every element takes at least one byte, so a count above the message's size is invalid.
    if (count < 0 || static_cast<uint64_t>(count) > bytes_.size()) return false;
    const auto size = static_cast<size_t>(count);
    if (plain && depth + 1 == field.dimensions.size()) return values(field, size);
    if constexpr (requires { sink_.name_array(field.name); }) sink_.name_array(field.name);
    sink_.begin_array(size);
    for (size_t i = 0; i < size; ++i) {
      if (++elements_ > 2 * bytes_.size()) return false;
      if constexpr (requires { sink_.begin_element(i); }) sink_.begin_element(i);
      if (!this->dimension(field, counts, depth + 1)) return false;
      if constexpr (requires { sink_.end_element(); }) sink_.end_element();
    }
    sink_.end_array();
    return true;
  }

  bool values(const Field& field, size_t count) {
    const size_t size = size_of(field.kind);
    if (count > (bytes_.size() - at_) / size) return false;
    sink_.values(field, bytes_.subspan(at_, count * size), count);
    at_ += count * size;
    return true;
  }

  bool element(const Field& field) {
    if (field.kind == Kind::kStruct) {
      sink_.begin_struct(&field);
      if (!fields(*field.schema)) return false;
      sink_.end_struct();
      return true;
    }
    if (bytes_.size() - at_ < 4) return false;
    const auto length = big_endian<int32_t>(bytes_.subspan(at_));
    at_ += 4;
    // The length includes the terminating zero.
    if (length < 1 || static_cast<size_t>(length) > bytes_.size() - at_) return false;
    sink_.values(field, bytes_.subspan(at_, static_cast<size_t>(length) - 1), 1);
    at_ += static_cast<size_t>(length);
    return true;
  }

  std::span<const uint8_t> bytes_;
  Sink& sink_;
  size_t at_ = 0, elements_ = 0;
};

}  // namespace multireach
