#include "tools/robot/bridge_words.hpp"

#include <fmt/format.h>

#include <array>

#include "robot_bridge/bridge.hpp"

namespace multireach {
namespace {

constexpr std::array kWords{
    BridgeWord{"enable", bridge_request_t::ENABLE, "let the bridge command the robot"},
    BridgeWord{"disable", bridge_request_t::DISABLE, "decelerate, then send no commands"},
    BridgeWord{"stop", bridge_request_t::DISABLE, "the same as disable"},
    BridgeWord{"pause", bridge_request_t::PAUSE, "decelerate and wait"},
    BridgeWord{"resume", bridge_request_t::RESUME, "continue at the speed of before"},
    BridgeWord{"reset", bridge_request_t::RESET, "leave a fault, once the robot stands still"},
    BridgeWord{"status", bridge_request_t::STATUS, "print the state, and how far the hand is from its target"},
};

}  // namespace

std::span<const BridgeWord> bridge_words() {
  return kWords;
}

std::string text_of(const bridge_state_t& state) {
  static constexpr std::array kStates{"idle", "armed", "running", "stopping", "fault"};
  const auto index = static_cast<size_t>(state.state);
  std::string text = index < kStates.size() ? kStates[index] : "unknown";
  if (!state.cause.empty()) text += ": " + state.cause;
  return text + fmt::format(", speed {:.0f} %, path rate {:.0f} %", 100 * state.speed, 100 * state.path_rate);
}

bool asks_all(int8_t kind) {
  return kind == bridge_request_t::DISABLE || kind == bridge_request_t::PAUSE;
}

bool asks_to_move(int8_t kind) {
  return kind == bridge_request_t::ENABLE || kind == bridge_request_t::RESUME || kind == bridge_request_t::RESET ||
         kind == bridge_request_t::SPEED;
}

std::string hindrance_of(int8_t kind, const bridge_state_t& state) {
  if (kind != bridge_request_t::ENABLE && kind != bridge_request_t::RESUME) return "";
  if (state.state == bridge_state_t::FAULT) return "nothing moves in a fault: `multireach-robot reset` leaves it";
  const bool disabled =
      state.state == bridge_state_t::IDLE || (state.state == bridge_state_t::STOPPING && state.cause == "disabled");
  if (kind == bridge_request_t::RESUME && disabled)
    return "`resume` only ends a pause, and the robot is not enabled: `multireach-robot enable`";
  if (kind == bridge_request_t::ENABLE && state.cause == "paused")
    return "the robot is paused: `multireach-robot resume`";
  if (state.speed < robot_bridge::Bridge::kMinSpeed) return "the speed override is 0: `multireach-robot speed PERCENT`";
  return "";
}

std::string refusal_of(int8_t kind) {
  return kind == bridge_request_t::RESET ? "the bridge refuses this now: there is no fault (after stop or disable, "
                                           "`enable` goes on), or the robot is silent or moves"
                                         : "the bridge refuses this now";
}

}  // namespace multireach
