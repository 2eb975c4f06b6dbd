#include "runtime/message_schema.hpp"

#include <gtest/gtest.h>

#include <multireach/controller_state_t.hpp>
#include <multireach/images_t.hpp>
#include <multireach/joint_command_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/node_inputs_t.hpp>
#include <multireach/node_status_t.hpp>
#include <multireach/obstacles_t.hpp>
#include <multireach/perturbation_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>

#include "numeric/random.hpp"
#include "runtime/message.hpp"

namespace multireach {
namespace {

const MessageSchemas& project() {
  return MessageSchemas::project();
}

template <class Message>
void expect_known(const Message& message) {
  const auto bytes = encode(message);
  ASSERT_TRUE(bytes);
  const MessageSchema* schema = project().of(*bytes);
  ASSERT_NE(schema, nullptr) << Message::getTypeName() << ": the fingerprint is not lcm-gen's";
  EXPECT_EQ(schema->name, Message::getTypeName());
  EXPECT_EQ(schema->fingerprint, Message::getHash());
  EXPECT_TRUE(well_formed(*schema, *bytes));
}

images_t stereo_images() {
  images_t images{};
  images.utime = 77;
  images.n_images = 2;
  images.image_types = {0, 1};
  images.images.resize(2);
  for (image_t& image : images.images) {
    image.data = {1, 2, 3, 250};
    image.size = 4;
    image_metadata_t other, sequence;
    other.key = "exposure";
    other.n = 1;
    other.value = {'9'};
    sequence.key = "sequence";
    sequence.n = 2;
    sequence.value = {'4', '2'};
    image.nmetadata = 2;
    image.metadata = {other, sequence};
  }
  return images;
}

target_t target() {
  target_t message{};
  message.utime = 1234567;
  message.sequence = 42;
  message.status = target_t::STATUS_TRACKED;
  message.name = "ball";
  for (int i = 0; i < 3; ++i) {
    message.position_m[i] = 0.1 * (i + 1);
    for (int k = 0; k < 3; ++k) message.covariance_m2[i][k] = 10 * i + k;
  }
  return message;
}

TEST(MessageSchema, HasTheFingerprintsOfLcmGen) {
  expect_known(target());
  expect_known(stereo_images());
  expect_known(controller_state_t{});
  expect_known(joint_command_t{});
  expect_known(joint_setpoint_t{});
  expect_known(node_inputs_t{});
  expect_known(node_status_t{});
  expect_known(obstacles_t{});
  expect_known(perturbation_t{});
  expect_known(robot_state_t{});
  EXPECT_EQ(project().of(std::vector<uint8_t>{1, 2, 3}), nullptr);
}

TEST(MessageSchema, KnowsForeignTypes) {
  MessageSchemas schemas;
  schemas.add(
      {"package drake; struct lcmt_iiwa_command { int64_t utime; int32_t num_joints; double "
       "joint_position[num_joints]; int32_t num_torques; double joint_torque[num_torques]; }",
       "package drake; struct lcmt_viewer_draw { int64_t timestamp; int32_t num_links; string "
       "link_name[num_links]; int32_t robot_num[num_links]; float position[num_links][3]; float "
       "quaternion[num_links][4]; }"});
  EXPECT_EQ(static_cast<uint64_t>(schemas.all()[0]->fingerprint), 0xddc7c7738c815334U);
  EXPECT_EQ(static_cast<uint64_t>(schemas.all()[1]->fingerprint), 0x414f0bfe5b2f4244U);
}

TEST(MessageSchema, GivesFieldsInOrder) {
  const auto bytes = *encode(target());
  const auto leaves = leaves_of(*project().of(bytes), bytes);
  ASSERT_TRUE(leaves);
  EXPECT_EQ(leaves->at(0).path, "utime");
  EXPECT_EQ(leaves->at(0).text(), "1234567");
  EXPECT_EQ(leaves->at(8).text(), "\"ball\"");
  EXPECT_EQ(leaves->at(11).path, "position_m[1]");
  EXPECT_EQ(leaves->at(11).text(), "0.2");
  EXPECT_EQ(leaves->at(21).path, "covariance_m2[1][2]");
  EXPECT_EQ(leaves->at(21).text(), "12");
  const auto pair = *encode(stereo_images());
  const auto in_images = *leaves_of(*project().of(pair), pair);
  const auto found = std::ranges::find(in_images, "images[1].metadata[1].key", &MessageLeaf::path);
  ASSERT_NE(found, in_images.end());
  EXPECT_EQ(found->text(), "\"sequence\"");
}

TEST(MessageSchema, GivesJsonAndItsSchema) {
  const auto bytes = *encode(target());
  const auto json = *json_of(*project().of(bytes), bytes);
  EXPECT_EQ(json["covariance_m2"][1][2], 12);
  EXPECT_EQ(json["name"], "ball");
  EXPECT_EQ(json.begin().key(), "utime") << "fields in their order";
  const auto pair = *encode(stereo_images());
  const auto images = *json_of(*project().of(pair), pair);
  EXPECT_EQ(images["images"][1]["data"], "AQID+g==");
  EXPECT_EQ(images["images"].size(), 2U);
  const auto schema = json_schema_of(*project().of(bytes));
  EXPECT_EQ(schema["properties"]["covariance_m2"]["items"]["items"]["type"], "number");
}

TEST(MessageSchema, FindsSequences) {
  const auto bytes = *encode(target()), pair = *encode(stereo_images());
  EXPECT_EQ(sequence_of(*project().of(bytes), bytes), 42);
  EXPECT_EQ(sequence_of(*project().of(pair), pair), 42) << "in the images' metadata";
  const auto status = *encode(node_status_t{});
  EXPECT_FALSE(sequence_of(*project().of(status), status));
}

/// The walk over the bytes and lcm-gen's hardened decoder agree about what is a message.
TEST(MessageSchema, AgreesWithTheDecoderOnGarbledMessages) {
  constexpr uint64_t kSeed = 21;
  const CounterRandom random(kSeed);
  uint64_t counter = 0;
  const auto whole = *encode(stereo_images());
  const MessageSchema& schema = *project().of(whole);
  int accepted = 0;
  for (int k = 0; k < 20000; ++k) {
    auto bytes = whole;
    for (int change = 0; change < 1 + k % 3; ++change) {
      const size_t at = random.bits(counter++) % bytes.size();
      bytes[at] ^= static_cast<uint8_t>(1 << random.bits(counter++) % 8);
    }
    if (k % 5 == 0) bytes.resize(random.bits(counter++) % (bytes.size() + 1));
    const bool decoded = decode<images_t>(bytes).has_value();
    ASSERT_EQ(well_formed(schema, bytes), decoded) << "seed " << kSeed << ", case " << k;
    accepted += decoded;
  }
  EXPECT_GT(accepted, 1000);
}

TEST(MessageSchema, SaysWhatIsNoDefinition) {
  const auto add = [](std::string_view text) {
    MessageSchemas schemas;
    schemas.add({text});
  };
  EXPECT_THROW(add("struct a { int64_t"), std::invalid_argument);
  EXPECT_THROW(add("struct a { other_t b; }"), std::invalid_argument);
  EXPECT_THROW(add("struct a { double b[n]; }"), std::invalid_argument);
  EXPECT_THROW(add("enum a { B }"), std::invalid_argument);
}

}  // namespace
}  // namespace multireach
