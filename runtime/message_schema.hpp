#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace multireach {

/// The definition of an LCM type, parsed from a .lcm file. With it, messages of the type are read without generated
/// code.
struct MessageSchema {
  enum class Kind { kBoolean, kByte, kInt8, kInt16, kInt32, kInt64, kFloat, kDouble, kString, kStruct };
  struct Dimension {
    size_t size = 0;   ///< for a fixed size
    int field = -1;    ///< index of the field that holds the size; -1 for a fixed size
    std::string text;  ///< as in the .lcm file
  };
  struct Field {
    std::string name, type;
    Kind kind = Kind::kStruct;
    const MessageSchema* schema = nullptr;  ///< definition of a struct field's type
    std::vector<Dimension> dimensions;
  };
  std::string name;  ///< without its package
  std::vector<Field> fields;
  int64_t fingerprint = 0;  ///< first eight bytes of each message
};

/// One value in a message.
struct MessageLeaf {
  std::string path;  ///< as "images[1].utime"; each number of an array is a leaf, a byte array is a single leaf
  MessageSchema::Kind kind = MessageSchema::Kind::kByte;
  std::span<const uint8_t> bytes;  ///< view into the message

  /// Human-readable; floating-point numbers with the fewest digits that convert back to the same value.
  std::string text() const;
};

/// The known message types, by fingerprint.
class MessageSchemas {
 public:
  /// The project's own types, compiled in.
  static const MessageSchemas& project();

  /// Adds the structs defined in .lcm texts. Throws std::invalid_argument with a sentence when a text is not a valid
  /// definition, or when a struct that a field refers to has not been added.
  void add(const std::vector<std::string_view>& lcm_texts);
  /// The type of a message; null when unknown.
  const MessageSchema* of(std::span<const uint8_t> message) const;
  std::vector<const MessageSchema*> all() const;

 private:
  std::vector<std::unique_ptr<MessageSchema>> schemas_;
  std::map<int64_t, const MessageSchema*> by_fingerprint_;
};

/// Whether the bytes are exactly one well-formed message of the type.
[[nodiscard]] bool well_formed(const MessageSchema& schema, std::span<const uint8_t> message);
/// The message's sequence number: the field `sequence`, or for images_t the decimal metadata "sequence" of the first
/// image that has one. Nothing when it is absent or negative.
std::optional<int64_t> sequence_of(const MessageSchema& schema, std::span<const uint8_t> message);
/// All values in order; nothing when the message is not well-formed.
std::optional<std::vector<MessageLeaf>> leaves_of(const MessageSchema& schema, std::span<const uint8_t> message);
/// The message as JSON, fields in order; byte arrays as base64, non-finite numbers as null. Nothing when the message is
/// not well-formed.
std::optional<nlohmann::ordered_json> json_of(const MessageSchema& schema, std::span<const uint8_t> message);
/// The JSON Schema of the output of `json_of`.
nlohmann::ordered_json json_schema_of(const MessageSchema& schema);

/// Base64 (RFC 4648), the encoding of byte arrays in JSON.
std::string base64(std::span<const uint8_t> bytes);

}  // namespace multireach
