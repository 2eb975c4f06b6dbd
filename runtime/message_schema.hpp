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

/// The definition of an LCM type, as a .lcm file gives it: reads any message of the type without generated code.
struct MessageSchema {
  enum class Kind { kBoolean, kByte, kInt8, kInt16, kInt32, kInt64, kFloat, kDouble, kString, kStruct };
  struct Dimension {
    size_t size = 0;   ///< where it is fixed
    int field = -1;    ///< the field of the struct that holds it, where it is not
    std::string text;  ///< as written
  };
  struct Field {
    std::string name, type;
    Kind kind = Kind::kStruct;
    const MessageSchema* schema = nullptr;  ///< of a struct
    std::vector<Dimension> dimensions;
  };
  std::string name;  ///< without its package
  std::vector<Field> fields;
  int64_t fingerprint = 0;  ///< the first eight bytes of its messages
};

/// A value inside a message.
struct MessageLeaf {
  std::string path;  ///< as "images[1].utime"; an array of numbers or bytes is one leaf for each number, or one for all
                     ///< bytes
  MessageSchema::Kind kind = MessageSchema::Kind::kByte;
  std::span<const uint8_t> bytes;  ///< in the message

  /// As people read it: shortest digits that give the same number back.
  std::string text() const;
};

/// The types that are known, by fingerprint.
class MessageSchemas {
 public:
  /// The project's own, built in.
  static const MessageSchemas& project();

  /// Adds the structs of .lcm texts. Throws std::invalid_argument with a sentence for what is no definition, or for a
  /// struct that is not among all that were added.
  void add(const std::vector<std::string_view>& lcm_texts);
  /// The type of a message; null when it is not known.
  const MessageSchema* of(std::span<const uint8_t> message) const;
  std::vector<const MessageSchema*> all() const;

 private:
  std::vector<std::unique_ptr<MessageSchema>> schemas_;
  std::map<int64_t, const MessageSchema*> by_fingerprint_;
};

/// Whether the bytes are exactly one well-formed message of the type.
bool well_formed(const MessageSchema& schema, std::span<const uint8_t> message);
/// The publisher's count of its messages: field `sequence`, or for images_t the decimal metadata "sequence" of its
/// first image that has one. Nothing where there is none, or it is negative.
std::optional<int64_t> sequence_of(const MessageSchema& schema, std::span<const uint8_t> message);
/// All values in their order; nothing when the message is not well-formed.
std::optional<std::vector<MessageLeaf>> leaves_of(const MessageSchema& schema, std::span<const uint8_t> message);
/// The message as JSON, fields in their order; byte arrays as base64, numbers that are not finite as null. Nothing when
/// it is not well-formed.
std::optional<nlohmann::ordered_json> json_of(const MessageSchema& schema, std::span<const uint8_t> message);
/// The JSON Schema of what `json_of` gives.
nlohmann::ordered_json json_schema_of(const MessageSchema& schema);

/// Base64 (RFC 4648), as byte arrays have it in JSON.
std::string base64(std::span<const uint8_t> bytes);

}  // namespace multireach
