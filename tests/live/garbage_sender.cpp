// Sends garbled messages on every channel, seeded.
#include <lcm/lcm-cpp.hpp>
#include <thread>

#include <multireach/images_t.hpp>
#include <multireach/joint_command_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>
#include "numeric/random.hpp"
#include "runtime/channels.hpp"
#include "runtime/message.hpp"

namespace multireach {
namespace {

template <class Message>
std::vector<uint8_t> beginning_of() {
  std::vector<uint8_t> bytes(8);
  const auto hash = static_cast<uint64_t>(Message::getHash());
  for (int i = 0; i < 8; ++i) bytes[static_cast<size_t>(i)] = static_cast<uint8_t>(hash >> (56 - 8 * i));
  return bytes;
}

int send() {
  lcm::LCM control{std::string(channel::kControlUrl)}, images{std::string(channel::kImageUrl)};
  if (!control.good() || !images.good()) return 1;
  const std::vector<std::pair<std::string_view, std::vector<uint8_t>>> beginnings{
      {channel::kStereoImages, beginning_of<images_t>()},
      {channel::kTarget, beginning_of<target_t>()},
      {channel::kJointSetpoint, beginning_of<joint_setpoint_t>()},
      {channel::kJointCommand, beginning_of<joint_command_t>()},
      {channel::kRobotState, beginning_of<robot_state_t>()},
      {channel::kPerturbation, {}},
      {channel::kObstacles, {}},
      {channel::kVisionDebugRequest, {}},
      {channel::kNodeStatus, {}}};
  const CounterRandom random(99);
  for (uint64_t k = 0; k < 200; ++k) {
    for (const auto& [channel, beginning] : beginnings) {
      std::vector<uint8_t> bytes = k % 2 ? beginning : std::vector<uint8_t>{};
      const size_t size = random.bits(1000000 + k) % 300;
      for (size_t i = 0; i < size; ++i) bytes.push_back(static_cast<uint8_t>(random.bits(k * 1000 + i)));
      (channel::on_image_group(channel) ? images : control)
          .publish(std::string(channel), bytes.data(), static_cast<unsigned>(bytes.size()));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return 0;
}

}  // namespace
}  // namespace multireach

int main() {
  return multireach::send();
}
