#include "runtime/message_schema.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cmath>

#include "runtime/message_walk.hpp"

namespace multireach {
namespace {

using Kind = MessageSchema::Kind;
using json = nlohmann::ordered_json;

/// Ignores all values; checks only that the message is well-formed.
struct NoSink {
  void begin_struct(const MessageSchema::Field*) {}
  void end_struct() {}
  void begin_array(size_t) {}
  void end_array() {}
  void values(const MessageSchema::Field&, std::span<const uint8_t>, size_t) {}
};

/// Finds the first top-level integer `sequence`, or the image metadata of that name.
struct SequenceSink : NoSink {
  void begin_struct(const MessageSchema::Field*) { ++depth; }
  void end_struct() { --depth; }
  void values(const MessageSchema::Field& field, std::span<const uint8_t> bytes, size_t) {
    if (depth == 1 && field.kind == Kind::kInt64 && field.dimensions.empty() && field.name == "sequence" && !sequence) {
      sequence = big_endian<int64_t>(bytes);
    }
    if (field.kind == Kind::kString && field.name == "key") {
      is_sequence = std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()) == "sequence";
    }
    if (field.kind == Kind::kByte && field.name == "value" && is_sequence && !metadata) {
      int64_t value = -1;
      const char* begin = reinterpret_cast<const char*>(bytes.data());
      const auto [end, error] = std::from_chars(begin, begin + bytes.size(), value);
      if (error == std::errc() && end == begin + bytes.size()) metadata = value;
    }
  }
  int depth = 0;
  bool is_sequence = false;
  std::optional<int64_t> sequence, metadata;
};

class LeafSink {
 public:
  explicit LeafSink(std::vector<MessageLeaf>& leaves) : leaves_(leaves) {}
  void begin_struct(const MessageSchema::Field* field) {
    if (field) enter(field->name);
  }
  void end_struct() { leave(); }
  void begin_array(size_t) {}
  void end_array() {}
  void begin_element(size_t index) { indices_ += fmt::format("[{}]", index); }
  void end_element() { indices_.resize(indices_.rfind('[')); }
  void values(const MessageSchema::Field& field, std::span<const uint8_t> bytes, size_t count) {
    const std::string path = join(prefix_, field.name) + indices_;
    if (field.kind == Kind::kByte || field.kind == Kind::kString) {
      leaves_.push_back({path, field.kind, bytes});
      return;
    }
    const size_t size = count ? bytes.size() / count : 0;
    for (size_t i = 0; i < count; ++i) {
      const bool array = !field.dimensions.empty();
      leaves_.push_back({array ? fmt::format("{}[{}]", path, i) : path, field.kind, bytes.subspan(i * size, size)});
    }
  }

 private:
  static std::string join(const std::string& a, const std::string& b) {
    if (a.empty()) return b;
    std::string joined = a;
    joined += '.';
    joined += b;
    return joined;
  }
  void enter(const std::string& name) {
    outer_.emplace_back(prefix_, indices_);
    prefix_ = join(prefix_, name) + indices_;
    indices_.clear();
  }
  void leave() {
    if (outer_.empty()) return;
    std::tie(prefix_, indices_) = outer_.back();
    outer_.pop_back();
  }

  std::vector<MessageLeaf>& leaves_;
  std::string prefix_, indices_;
  std::vector<std::pair<std::string, std::string>> outer_;
};

template <class Number>
json number(Number value) {
  if constexpr (std::is_floating_point_v<Number>) {
    if (!std::isfinite(value)) return nullptr;
  }
  return value;
}

json value_of(Kind kind, std::span<const uint8_t> bytes) {
  switch (kind) {
    case Kind::kBoolean:
      return bytes[0] != 0;
    case Kind::kByte:
      return base64(bytes);
    case Kind::kInt8:
    case Kind::kInt16:
    case Kind::kInt32:
    case Kind::kInt64:
      return integer_in(kind, bytes);
    case Kind::kFloat:
      return number(std::bit_cast<float>(big_endian<uint32_t>(bytes)));
    case Kind::kDouble:
      return number(std::bit_cast<double>(big_endian<uint64_t>(bytes)));
    case Kind::kString:
    case Kind::kStruct:
      break;
  }
  // Bytes that are not valid Unicode become replacement characters when the JSON is written.
  return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

class JsonSink {
 public:
  explicit JsonSink(json& root) { stack_.push_back(&root); }
  void begin_struct(const MessageSchema::Field* field) {
    if (!field) {
      *stack_.back() = json::object();
      return;
    }
    stack_.push_back(&insert(field->name, json::object()));
  }
  void end_struct() { stack_.pop_back(); }
  void begin_array(size_t) { stack_.push_back(&insert(*array_name_, json::array())); }
  void end_array() { stack_.pop_back(); }
  void begin_element(size_t) {}
  void end_element() {}
  void name_array(const std::string& name) { array_name_ = &name; }
  void values(const MessageSchema::Field& field, std::span<const uint8_t> bytes, size_t count) {
    const bool whole = field.kind == Kind::kByte || field.kind == Kind::kString;
    if (whole || field.dimensions.empty()) {
      insert(field.name, value_of(field.kind, bytes));
      return;
    }
    json list = json::array();
    const size_t size = count ? bytes.size() / count : 0;
    for (size_t i = 0; i < count; ++i) list.push_back(value_of(field.kind, bytes.subspan(i * size, size)));
    insert(field.name, std::move(list));
  }

 private:
  json& insert(const std::string& name, json value) {
    json& at = *stack_.back();
    if (at.is_array()) {
      at.push_back(std::move(value));
      return at.back();
    }
    return at[name] = std::move(value);
  }
  std::vector<json*> stack_;
  const std::string* array_name_ = nullptr;
};

template <class Sink>
bool read(const MessageSchema& schema, std::span<const uint8_t> message, Sink& sink) {
  MessageWalk<Sink> walk(message, sink);
  return walk.parse(schema);
}

}  // namespace

bool well_formed(const MessageSchema& schema, std::span<const uint8_t> message) {
  NoSink sink;
  return read(schema, message, sink);
}

std::optional<int64_t> sequence_of(const MessageSchema& schema, std::span<const uint8_t> message) {
  SequenceSink sink;
  if (!read(schema, message, sink)) return std::nullopt;
  const auto sequence = sink.sequence ? sink.sequence : sink.metadata;
  return sequence && *sequence >= 0 ? sequence : std::nullopt;
}

std::optional<std::vector<MessageLeaf>> leaves_of(const MessageSchema& schema, std::span<const uint8_t> message) {
  std::vector<MessageLeaf> leaves;
  LeafSink sink(leaves);
  if (!read(schema, message, sink)) return std::nullopt;
  return leaves;
}

std::optional<json> json_of(const MessageSchema& schema, std::span<const uint8_t> message) {
  json root;
  JsonSink sink(root);
  if (!read(schema, message, sink)) return std::nullopt;
  return root;
}

json json_schema_of(const MessageSchema& schema) {
  json properties = json::object();
  for (const MessageSchema::Field& field : schema.fields) {
    json type;
    switch (field.kind) {
      case Kind::kBoolean:
        type = {{"type", "boolean"}};
        break;
      case Kind::kString:
        type = {{"type", "string"}};
        break;
      case Kind::kByte:
        type = {{"type", "string"}, {"contentEncoding", "base64"}};
        break;
      case Kind::kFloat:
      case Kind::kDouble:
        type = {{"type", "number"}};
        break;
      case Kind::kStruct:
        type = json_schema_of(*field.schema);
        break;
      default:
        type = {{"type", "integer"}};
    }
    const size_t wraps = field.dimensions.size() - (field.kind == Kind::kByte && !field.dimensions.empty() ? 1 : 0);
    for (size_t i = 0; i < wraps; ++i) type = {{"type", "array"}, {"items", type}};
    properties[field.name] = type;
  }
  return {{"title", schema.name}, {"type", "object"}, {"properties", properties}};
}

std::string MessageLeaf::text() const {
  if (kind == Kind::kByte) {
    if (bytes.size() == 1) return std::to_string(bytes[0]);
    return fmt::format("{} bytes", bytes.size());
  }
  if (kind == Kind::kDouble) return fmt::format("{}", std::bit_cast<double>(big_endian<uint64_t>(bytes)));
  if (kind == Kind::kFloat) return fmt::format("{}", std::bit_cast<float>(big_endian<uint32_t>(bytes)));
  const json value = value_of(kind, bytes);
  // Quoted, with control and non-ASCII characters escaped.
  return value.dump(-1, ' ', true, json::error_handler_t::replace);
}

std::string base64(std::span<const uint8_t> bytes) {
  static constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t left = std::min<size_t>(3, bytes.size() - i);
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (k < left ? bytes[i + k] : 0U);
    for (size_t k = 0; k < 4; ++k) text.push_back(k <= left ? kDigits[group >> (18 - 6 * k) & 63] : '=');
  }
  return text;
}

}  // namespace multireach
