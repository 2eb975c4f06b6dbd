// Sends garbled messages on every channel, and malformed datagrams to both groups, seeded.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

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

/// Sends datagrams that end the receiver of LCM 1.3 where nothing stands before it: fragments beyond their message, and
/// a channel's name without an end.
bool send_malformed_datagrams(const char* address, uint16_t port) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  inet_pton(AF_INET, address, &to.sin_addr);
  const auto send_to_group = [&](const std::vector<uint8_t>& bytes) {
    return sendto(socket, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to) > 0;
  };
  const auto fragment = [](uint32_t sequence, uint32_t size, uint32_t offset, uint16_t number, size_t payload) {
    std::vector<uint8_t> bytes{'L', 'C', '0', '3'};
    const auto put = [&bytes](uint32_t value, int width) {
      for (int k = width - 1; k >= 0; --k) bytes.push_back(static_cast<uint8_t>(value >> (8 * k)));
    };
    put(sequence, 4);
    put(size, 4);
    put(offset, 4);
    put(number, 2);
    put(2, 2);
    if (number == 0) bytes.insert(bytes.end(), {'N', 'O', 'D', 'E', '_', 'S', 'T', 'A', 'T', 'U', 'S', 0});
    bytes.insert(bytes.end(), payload, 0xaa);
    return bytes;
  };
  bool sent = true;
  for (uint32_t k = 0; k < 20; ++k) {
    sent = sent && send_to_group(fragment(k, 1000, 0, 0, 100)) &&
           send_to_group(fragment(k, 1000, 0xffffff00 + k, 1, 0x100));
    std::vector<uint8_t> endless{'L', 'C', '0', '2', 0, 0, 0, 1};
    endless.insert(endless.end(), 60000, 'a');
    sent = sent && send_to_group(endless);
  }
  close(socket);
  return sent;
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
  if (!send_malformed_datagrams("239.255.76.67", 7667) || !send_malformed_datagrams("239.255.76.68", 7668)) return 1;
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
