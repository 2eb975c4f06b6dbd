#pragma once

// Messages for nodes that run without LCM and without a clock, and what they answer.
#include <gtest/gtest.h>

#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>

#include "runtime/message.hpp"
#include "runtime/node.hpp"
#include "runtime/robot_config.hpp"

namespace multireach::testing {

inline RobotConfig robot() {
  return RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml");
}

template <class Message>
Message last_of(const Outbox& out, std::string_view channel) {
  for (auto message = out.rbegin(); message != out.rend(); ++message) {
    if (message->channel == channel) return *decode<Message>(message->bytes);
  }
  ADD_FAILURE() << "nothing on " << channel;
  return {};
}

inline std::vector<uint8_t> robot_state(int64_t sequence) {
  robot_state_t state{};
  state.sequence = sequence;
  state.command_sequence = -1;
  state.simulated = true;
  state.num_joints = 5;
  state.joint_name = {"right_EB", "left_EB", "right_SFE", "right_SHR", "right_SAA"};
  state.joint_position = {-0.9, 0, 0.2, -0.2, -0.3};
  state.joint_velocity = state.joint_effort = std::vector<double>(5, 0.0);
  return *encode(state);
}

inline std::vector<uint8_t> target(int64_t sequence, int64_t utime, const Eigen::Vector3d& p,
                                   int8_t status = target_t::STATUS_TRACKED, const std::string& name = "ball") {
  target_t message{};
  message.name = name;
  message.sequence = sequence;
  message.utime = utime;
  message.status = status;
  Eigen::Map<Eigen::Vector3d>(message.position_m) = p;
  return *encode(message);
}

inline const Eigen::Vector3d kFront(0.10, -0.12, 0.10);

}  // namespace multireach::testing
