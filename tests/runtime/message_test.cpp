#include "runtime/message.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <multireach/all_types.hpp>

#include "numeric/random.hpp"
#include "runtime/message_schema.hpp"
#include "tests/allocation_count.hpp"

namespace multireach {
namespace {

constexpr int32_t kLength = 3;  // of every array whose length is a field

template <class Number>
void append(Number value, std::vector<uint8_t>& bytes) {
  for (size_t i = 0; i < sizeof(Number); ++i) {
    bytes.push_back(static_cast<uint8_t>(static_cast<uint64_t>(value) >> (8 * (sizeof(Number) - 1 - i))));
  }
}

void append_struct(const MessageSchema& schema, std::vector<uint8_t>& bytes);

void append_value(const MessageSchema::Field& field, bool is_length, std::vector<uint8_t>& bytes) {
  using Kind = MessageSchema::Kind;
  const int64_t number = is_length ? kLength : 1;
  switch (field.kind) {
    case Kind::kBoolean:
    case Kind::kByte:
    case Kind::kInt8:
      return append(static_cast<int8_t>(number), bytes);
    case Kind::kInt16:
      return append(static_cast<int16_t>(number), bytes);
    case Kind::kInt32:
      return append(static_cast<int32_t>(number), bytes);
    case Kind::kInt64:
      return append(number, bytes);
    case Kind::kFloat:
      return append(std::bit_cast<uint32_t>(0.25F), bytes);
    case Kind::kDouble:
      return append(std::bit_cast<uint64_t>(0.25), bytes);
    case Kind::kString:
      append(int32_t{3}, bytes);
      bytes.insert(bytes.end(), {'a', 'b', 0});
      return;
    case Kind::kStruct:
      return append_struct(*field.schema, bytes);
  }
}

void append_struct(const MessageSchema& schema, std::vector<uint8_t>& bytes) {
  for (size_t f = 0; f < schema.fields.size(); ++f) {
    const MessageSchema::Field& field = schema.fields[f];
    bool is_length = false;
    for (const auto& other : schema.fields) {
      for (const auto& dimension : other.dimensions) is_length = is_length || dimension.field == static_cast<int>(f);
    }
    size_t count = 1;
    for (const auto& dimension : field.dimensions) count *= dimension.field >= 0 ? kLength : dimension.size;
    for (size_t i = 0; i < count; ++i) append_value(field, is_length, bytes);
  }
}

/// A message with something in every field, made by the type's definition, not by the generated code.
template <class Message>
std::vector<uint8_t> example_bytes() {
  std::vector<uint8_t> bytes;
  append(static_cast<uint64_t>(Message::getHash()), bytes);
  const MessageSchema* schema = MessageSchemas::project().of(bytes);
  if (schema) append_struct(*schema, bytes);
  return bytes;
}

template <class Message>
Message example() {
  return decode<Message>(example_bytes<Message>()).value();
}

template <class Message>
class EveryType : public ::testing::Test {};
using Types = AllTypes<::testing::Types>;
TYPED_TEST_SUITE(EveryType, Types);

TYPED_TEST(EveryType, ComesBackAsItWas) {
  const std::vector<uint8_t> bytes = example_bytes<TypeParam>();
  const auto message = decode<TypeParam>(bytes);
  ASSERT_TRUE(message);
  EXPECT_EQ(encode(*message), bytes);
}

TYPED_TEST(EveryType, IsRefusedWhenCutOffOrTooLong) {
  const auto bytes = encode(example<TypeParam>());
  for (size_t size = 0; size < bytes->size(); ++size)
    EXPECT_FALSE(decode<TypeParam>(std::span(bytes->data(), size))) << size;
  auto longer = *bytes;
  longer.push_back(0);
  EXPECT_FALSE(decode<TypeParam>(longer));
  auto other = *bytes;
  other[0] ^= 1;
  EXPECT_FALSE(decode<TypeParam>(other)) << "another fingerprint";
}

/// Bytes of memory that a decoded message may take per byte of the message: a vector of one-byte strings is the worst,
/// 32 bytes of std::string for 5 on the wire.
constexpr int64_t kMemoryPerByte = 8;

TYPED_TEST(EveryType, AMillionMutationsDoNoHarm) {
  constexpr uint64_t kSeed = 20261121, kMutations = 1000000;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  const auto good = example_bytes<TypeParam>();
  const CounterRandom random(kSeed);
  std::vector<uint8_t> bytes;
  const int32_t extremes[] = {-1, 0, 1, 127, 65536, 268435457, INT32_MAX, INT32_MIN};
  int64_t most = 0, accepted = 0;
  for (uint64_t k = 0; k < kMutations; ++k) {
    bytes = good;
    const uint64_t r = random.bits(2 * k), s = random.bits(2 * k + 1);
    for (uint64_t change = 0; change <= r % 3; ++change) {
      const size_t at = 8 + (s >> (16 * change)) % (bytes.size() - 8);  // the fingerprint stays
      if ((r >> (8 + change)) % 2) {
        const auto value = static_cast<uint32_t>(extremes[(r >> (16 + 3 * change)) % 8]);
        for (size_t i = 0; i < 4 && at + i < bytes.size(); ++i)
          bytes[at + i] = static_cast<uint8_t>(value >> (24 - 8 * i));
      } else {
        bytes[at] ^= static_cast<uint8_t>(1 << ((r >> (24 + 3 * change)) % 8));
      }
    }
    if ((r >> 40) % 8 == 0) bytes.resize(8 + (r >> 44) % (bytes.size() - 8));
    const int64_t before = testing::allocations().bytes;
    accepted += decode<TypeParam>(bytes).has_value();
    most = std::max(most, testing::allocations().bytes - before);
  }
  EXPECT_LE(most, kMemoryPerByte * static_cast<int64_t>(good.size()));
  EXPECT_GT(accepted, 0) << "flipped bits inside a number cannot be seen";
}

TEST(Encode, RefusesCountsThatDoNotAgreeWithTheirVectors) {
  joint_setpoint_t m = example<joint_setpoint_t>();
  EXPECT_TRUE(encode(m));
  m.num_joints = kLength + 1;
  EXPECT_FALSE(encode(m));
  m.num_joints = -1;
  EXPECT_FALSE(encode(m));
  m = example<joint_setpoint_t>();
  m.joint_name.pop_back();
  EXPECT_FALSE(encode(m));
  images_t images = example<images_t>();
  images.images[1].size = kLength + 1;
  EXPECT_FALSE(encode(images)) << "inside a nested type";
}

template <class Message>
uint64_t fingerprint() {
  return static_cast<uint64_t>(Message::getHash());
}

TEST(Fingerprints, AreThoseOfBotCore) {
  // As published for bot_core's types, field for field (their names and those of the structs do not count).
  EXPECT_EQ(fingerprint<images_t>(), 0x20ba4f05e8f5e33aU);
  EXPECT_EQ(fingerprint<image_t>(), 0x14739ffe13d5f5f0U);
  EXPECT_EQ(fingerprint<image_metadata_t>(), 0x9a4b634d0577fb8eU);
}

}  // namespace
}  // namespace multireach
