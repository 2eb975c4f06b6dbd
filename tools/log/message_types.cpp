#include "tools/log/message_types.hpp"

#include <map>
#include <multireach/controller_state_t.hpp>
#include <multireach/images_t.hpp>
#include <multireach/joint_command_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/node_status_t.hpp>
#include <multireach/obstacles_t.hpp>
#include <multireach/perturbation_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>

#include "runtime/message.hpp"

namespace multireach {
namespace {

template <class Message>
std::optional<int64_t> sequence_in(std::span<const uint8_t> bytes) {
  if constexpr (requires(Message message) { message.sequence; }) {
    if (const auto message = decode<Message>(bytes)) return message->sequence;
  }
  return std::nullopt;
}

template <class... Messages>
std::map<int64_t, MessageType> types() {
  return {{Messages::getHash(),
           {Messages::getTypeName(), [](std::span<const uint8_t> bytes) { return decode<Messages>(bytes).has_value(); },
            sequence_in<Messages>}}...};
}

}  // namespace

const MessageType* type_of(std::span<const uint8_t> bytes) {
  static const auto known = types<images_t, target_t, obstacles_t, joint_setpoint_t, controller_state_t,
                                  joint_command_t, robot_state_t, perturbation_t, node_status_t>();
  if (bytes.size() < 8) return nullptr;
  uint64_t hash = 0;
  for (size_t i = 0; i < 8; ++i) hash = (hash << 8) | bytes[i];
  const auto found = known.find(static_cast<int64_t>(hash));
  return found == known.end() ? nullptr : &found->second;
}

}  // namespace multireach
