#pragma once

#include <multireach/bridge_request_t.hpp>
#include <multireach/bridge_state_t.hpp>
#include <span>
#include <string>

namespace multireach {

/// A word by which a user asks the bridge for something.
struct BridgeWord {
  const char* word;
  int8_t kind;  ///< of bridge_request_t
  const char* help;
};

/// Every request but SPEED, which takes a number.
std::span<const BridgeWord> bridge_words();

/// "running, speed 100 %, path rate 100 %", with the cause where there is one.
std::string text_of(const bridge_state_t& state);
/// Whether a request of this kind, to stop or to pause, is for every bridge.
bool asks_all(int8_t kind);
/// Whether a request of this kind asks for motion, which needs a robot that is there.
bool asks_to_move(int8_t kind);
/// Why nothing moves in this state, although the bridge took a request of this kind; "" where something may move.
std::string hindrance_of(int8_t kind, const bridge_state_t& state);
/// Why the bridge refused a request of this kind.
std::string refusal_of(int8_t kind);

}  // namespace multireach
