#include "runtime/message.hpp"

#include <gtest/gtest.h>

#include <multireach/controller_state_t.hpp>
#include <multireach/debug_request_t.hpp>
#include <multireach/images_t.hpp>
#include <multireach/joint_command_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/node_status_t.hpp>
#include <multireach/obstacles_t.hpp>
#include <multireach/perturbation_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>

#include "numeric/random.hpp"
#include "tests/allocation_count.hpp"

namespace multireach {
namespace {

images_t example(images_t*) {
  images_t m{};
  m.utime = 5;
  m.n_images = 2;
  m.image_types = {0, 1};
  m.images.resize(2);
  for (image_t& image : m.images) {
    image = image_t{};
    image.width = 4;
    image.height = 2;
    image.size = 20;
    image.data.assign(20, 7);
    image.nmetadata = 1;
    image.metadata.resize(1);
    image.metadata[0].key = "sequence";
    image.metadata[0].n = 2;
    image.metadata[0].value = {'1', '2'};
  }
  return m;
}
image_t example(image_t*) {
  return example(static_cast<images_t*>(nullptr)).images[0];
}
image_metadata_t example(image_metadata_t*) {
  return example(static_cast<image_t*>(nullptr)).metadata[0];
}
target_t example(target_t*) {
  target_t m{};
  m.utime = 7;
  m.name = "ball";
  m.position_m[1] = 0.25;
  m.num_memory = 3;
  m.memory = {1, 2, 3};
  return m;
}
obstacle_t example(obstacle_t*) {
  obstacle_t m{};
  m.name = "table";
  return m;
}
obstacles_t example(obstacles_t*) {
  obstacles_t m{};
  m.num_obstacles = 3;
  m.obstacles.assign(3, example(static_cast<obstacle_t*>(nullptr)));
  return m;
}
perturbation_t example(perturbation_t*) {
  perturbation_t m{};
  m.link_name = "right_hand";
  return m;
}
debug_request_t example(debug_request_t*) {
  debug_request_t m{};
  m.utime = 9;
  m.name = "ball";
  return m;
}
node_status_t example(node_status_t*) {
  node_status_t m{};
  m.node = "vision";
  m.state = "seen";
  return m;
}
template <class Message>
Message with_joints() {
  Message m{};
  m.num_joints = 4;
  m.joint_name = {"a", "bc", "def", ""};
  m.angle_rad = {1, 2, 3, 4};
  return m;
}
joint_setpoint_t example(joint_setpoint_t*) {
  auto m = with_joints<joint_setpoint_t>();
  m.velocity_rad_s = m.angle_rad;
  return m;
}
joint_command_t example(joint_command_t*) {
  auto m = with_joints<joint_command_t>();
  m.velocity_rad_s = m.angle_rad;
  return m;
}
robot_state_t example(robot_state_t*) {
  auto m = with_joints<robot_state_t>();
  m.velocity_rad_s = m.torque_n_m = m.angle_rad;
  return m;
}
controller_state_t example(controller_state_t*) {
  auto m = with_joints<controller_state_t>();
  m.target_angle_rad = m.weight_rad2_m2 = m.angle_rad;
  return m;
}

template <class Message>
class EveryType : public ::testing::Test {
 protected:
  static Message message() { return example(static_cast<Message*>(nullptr)); }
};
using Types = ::testing::Types<images_t, image_t, image_metadata_t, target_t, obstacle_t, obstacles_t, perturbation_t,
                               debug_request_t, node_status_t, joint_setpoint_t, joint_command_t, robot_state_t,
                               controller_state_t>;
TYPED_TEST_SUITE(EveryType, Types);

TYPED_TEST(EveryType, ComesBackAsItWas) {
  const auto bytes = encode(this->message());
  ASSERT_TRUE(bytes);
  const auto back = decode<TypeParam>(*bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(encode(*back), bytes);
}

TYPED_TEST(EveryType, IsRefusedWhenCutOffOrTooLong) {
  const auto bytes = encode(this->message());
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
  const auto good = *encode(this->message());
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
  joint_setpoint_t m = example(static_cast<joint_setpoint_t*>(nullptr));
  EXPECT_TRUE(encode(m));
  m.num_joints = 5;
  EXPECT_FALSE(encode(m));
  m.num_joints = -1;
  EXPECT_FALSE(encode(m));
  m = example(static_cast<joint_setpoint_t*>(nullptr));
  m.joint_name.pop_back();
  EXPECT_FALSE(encode(m));
  images_t images = example(static_cast<images_t*>(nullptr));
  images.images[1].size = 21;
  EXPECT_FALSE(encode(images)) << "inside a nested type";
}

template <class Message>
uint64_t fingerprint() {
  return static_cast<uint64_t>(Message::getHash());
}

TEST(Fingerprints, AreThoseOfTheWireAsItWasFixed) {
  // A change here is a change of the wire: old logs and other programs no longer understand the type.
  EXPECT_EQ(fingerprint<images_t>(), 0x20ba4f05e8f5e33aU);
  EXPECT_EQ(fingerprint<image_t>(), 0x14739ffe13d5f5f0U);
  EXPECT_EQ(fingerprint<image_metadata_t>(), 0x9a4b634d0577fb8eU);
  EXPECT_EQ(fingerprint<target_t>(), 0xdaf515c503f3947cU);
  EXPECT_EQ(fingerprint<obstacle_t>(), 0x7a71590b61880e5fU);
  EXPECT_EQ(fingerprint<obstacles_t>(), 0x9fe2d870847d0bbaU);
  EXPECT_EQ(fingerprint<joint_setpoint_t>(), 0x7c911a46d2091bfeU);
  EXPECT_EQ(fingerprint<controller_state_t>(), 0xe986357bf8b9f5b9U);
  EXPECT_EQ(fingerprint<joint_command_t>(), 0x673bb772e319ad9fU);
  EXPECT_EQ(fingerprint<robot_state_t>(), 0x415b55983e86a48eU);
  EXPECT_EQ(fingerprint<perturbation_t>(), 0x33043e86c34bd651U);
  EXPECT_EQ(fingerprint<debug_request_t>(), 0x01848a2e575a842eU);
  EXPECT_EQ(fingerprint<node_status_t>(), 0x9fa807e962267c60U);
}

}  // namespace
}  // namespace multireach
