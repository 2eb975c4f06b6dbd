#pragma once

#include <cstdint>
#include <deque>
#include <multireach/bridge_request_t.hpp>
#include <multireach/bridge_state_t.hpp>
#include <optional>
#include <string>

namespace multireach {

/// What the bridge answered to a request of a user.
struct BridgeAnswer {
  std::string word;  ///< what was asked for, e.g. "pause"
  bool accepted = false;
  std::string text;  ///< the bridge's state, or why there is no answer
};

/// Asks the bridge, one request after the other, as `multireach-robot` does: a request names the run of the bridge, is
/// repeated until BRIDGE_STATE answers it, and given up after two seconds. Knows time only from its arguments.
class BridgeAsker {
 public:
  /// `first_request`: number of the first request; random, so that several askers differ.
  explicit BridgeAsker(int64_t first_request) : next_request_(first_request) {}

  /// Queues a request. DISABLE goes first, and replaces all that wait: nothing asked before a stop may follow it.
  void ask(const std::string& word, int8_t kind, double speed = 0);
  void receive(const bridge_state_t& state);
  /// The request to send now, if any. `now_us`: time, microseconds.
  std::optional<bridge_request_t> tick(int64_t now_us);
  std::optional<BridgeAnswer> take_answer();

 private:
  static constexpr int64_t kTimeout = 2000000;      // us
  static constexpr int64_t kRepeatPeriod = 200000;  // us
  static constexpr size_t kMaxWaiting = 16;

  struct Question {
    std::string word;
    bridge_request_t request;
  };
  void number(bridge_request_t& request) { request.request = next_request_++; }
  void finish(bool accepted, const std::string& text);

  int64_t next_request_;
  std::deque<Question> waiting_;  // the first one is being asked
  std::deque<BridgeAnswer> answers_;
  std::optional<int64_t> run_;  // of the bridge, once heard
  std::optional<int64_t> begun_us_, sent_us_;
};

}  // namespace multireach
