// Parses .lcm files and computes the fingerprints that lcm-gen gives their types.
#include <array>
#include <cctype>
#include <charconv>
#include <functional>
#include <set>
#include <stdexcept>

#include "runtime/message_schema.hpp"
#include "runtime/message_walk.hpp"
#include "runtime/schema_texts.hpp"

namespace multireach {
namespace {

using Kind = MessageSchema::Kind;
using Field = MessageSchema::Field;

constexpr std::array<std::pair<std::string_view, Kind>, 9> kPrimitives{{{"boolean", Kind::kBoolean},
                                                                        {"byte", Kind::kByte},
                                                                        {"int8_t", Kind::kInt8},
                                                                        {"int16_t", Kind::kInt16},
                                                                        {"int32_t", Kind::kInt32},
                                                                        {"int64_t", Kind::kInt64},
                                                                        {"float", Kind::kFloat},
                                                                        {"double", Kind::kDouble},
                                                                        {"string", Kind::kString}}};

class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) {}

  std::string next() {
    skip();
    if (at_ >= text_.size()) return {};
    const size_t begin = at_++;
    if (!is_word(text_[begin])) return std::string(text_.substr(begin, 1));
    while (at_ < text_.size() && is_word(text_[at_])) ++at_;
    return std::string(text_.substr(begin, at_ - begin));
  }
  void expect(const std::string& token) {
    const std::string found = next();
    if (found != token) fail("expected '" + token + "' and found '" + found + "'");
  }
  [[noreturn]] void fail(const std::string& what) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    throw std::invalid_argument("line " + std::to_string(line) + " of an LCM definition: " + what);
  }

 private:
  static bool is_word(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || c == '-';
  }
  void skip() {
    while (at_ < text_.size()) {
      if (std::isspace(static_cast<unsigned char>(text_[at_]))) {
        ++at_;
      } else if (text_.substr(at_, 2) == "//") {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (text_.substr(at_, 2) == "/*") {
        const size_t end = text_.find("*/", at_);
        at_ = end == std::string_view::npos ? text_.size() : end + 2;
      } else {
        return;
      }
    }
  }
  std::string_view text_;
  size_t at_ = 0;
};

MessageSchema::Dimension dimension_from(const std::string& text, const MessageSchema& schema, const Tokens& tokens) {
  MessageSchema::Dimension dimension;
  dimension.text = text;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), dimension.size);
  if (error == std::errc() && end == text.data() + text.size()) return dimension;
  for (size_t i = 0; i < schema.fields.size(); ++i) {
    const Field& field = schema.fields[i];
    const bool integer = field.kind >= Kind::kInt8 && field.kind <= Kind::kInt64 && field.dimensions.empty();
    if (field.name == text && integer) dimension.field = static_cast<int>(i);
  }
  if (dimension.field < 0) tokens.fail("'" + text + "' is neither a number nor an integer field before");
  return dimension;
}

std::unique_ptr<MessageSchema> struct_from(Tokens& tokens) {
  auto schema = std::make_unique<MessageSchema>();
  schema->name = tokens.next();
  tokens.expect("{");
  for (std::string type = tokens.next(); type != "}"; type = tokens.next()) {
    if (type.empty()) tokens.fail("the struct '" + schema->name + "' has no end");
    if (type == "const") {
      while (type != ";" && !type.empty()) type = tokens.next();
      continue;
    }
    std::string token;
    do {
      Field field;
      field.type = type;
      for (const auto& [name, kind] : kPrimitives) {
        if (name == type) field.kind = kind;
      }
      field.name = tokens.next();
      for (token = tokens.next(); token == "["; token = tokens.next()) {
        field.dimensions.push_back(dimension_from(tokens.next(), *schema, tokens));
        tokens.expect("]");
      }
      schema->fields.push_back(std::move(field));
    } while (token == ",");
    if (token != ";") tokens.fail("expected ';' and found '" + token + "'");
  }
  return schema;
}

// Fingerprints as lcm-gen computes them (lcmgen.c, lcm_struct_hash): they cover names, primitive types and dimensions.
int64_t with_byte(int64_t hash, char byte) {
  const auto bits = static_cast<uint64_t>(hash) << 8 ^ static_cast<uint64_t>(hash >> 55);
  return static_cast<int64_t>(bits + static_cast<uint64_t>(static_cast<int64_t>(byte)));
}

int64_t with_text(int64_t hash, std::string_view text) {
  hash = with_byte(hash, static_cast<char>(text.size()));
  for (const char c : text) hash = with_byte(hash, c);
  return hash;
}

int64_t fingerprint_of(const MessageSchema& schema, std::set<const MessageSchema*>& inside) {
  if (!inside.insert(&schema).second) return 0;  // a struct that contains itself
  int64_t own = 0x12345678;
  uint64_t members = 0;
  for (const Field& field : schema.fields) {
    own = with_text(own, field.name);
    if (field.kind != Kind::kStruct) own = with_text(own, field.type);
    own = with_byte(own, static_cast<char>(field.dimensions.size()));
    for (const auto& dimension : field.dimensions) {
      own = with_byte(own, dimension.field < 0 ? 0 : 1);
      own = with_text(own, dimension.text);
    }
    if (field.kind == Kind::kStruct) members += static_cast<uint64_t>(fingerprint_of(*field.schema, inside));
  }
  inside.erase(&schema);
  const uint64_t sum = static_cast<uint64_t>(own) + members;
  return static_cast<int64_t>(sum << 1 | sum >> 63);
}

std::string without_package(const std::string& name) {
  return name.substr(name.rfind('.') + 1);
}

}  // namespace

void MessageSchemas::add(const std::vector<std::string_view>& lcm_texts) {
  for (const std::string_view text : lcm_texts) {
    Tokens tokens(text);
    for (std::string token = tokens.next(); !token.empty(); token = tokens.next()) {
      if (token == "package") {
        tokens.next();
        tokens.expect(";");
      } else if (token == "struct") {
        schemas_.push_back(struct_from(tokens));
      } else {
        tokens.fail("expected 'package' or 'struct' and found '" + token + "'");
      }
    }
  }
  for (const auto& schema : schemas_) {
    for (Field& field : schema->fields) {
      if (field.kind != Kind::kStruct || field.schema) continue;
      for (const auto& other : schemas_) {
        if (other->name == without_package(field.type)) field.schema = other.get();
      }
      if (!field.schema) {
        throw std::invalid_argument("struct '" + schema->name + "' has a field of type '" + field.type +
                                    "', whose definition is not here");
      }
    }
  }
  for (const auto& schema : schemas_) {
    std::set<const MessageSchema*> inside;
    schema->fingerprint = fingerprint_of(*schema, inside);
    by_fingerprint_.emplace(schema->fingerprint, schema.get());
  }
}

const MessageSchema* MessageSchemas::of(std::span<const uint8_t> message) const {
  if (message.size() < 8) return nullptr;
  const auto found = by_fingerprint_.find(big_endian<int64_t>(message));
  return found == by_fingerprint_.end() ? nullptr : found->second;
}

std::vector<const MessageSchema*> MessageSchemas::all() const {
  std::vector<const MessageSchema*> all;
  for (const auto& schema : schemas_) all.push_back(schema.get());
  return all;
}

const MessageSchemas& MessageSchemas::project() {
  static const MessageSchemas kProject = [] {
    MessageSchemas schemas;
    schemas.add({kSchemaTexts.begin(), kSchemaTexts.end()});
    return schemas;
  }();
  return kProject;
}

}  // namespace multireach
