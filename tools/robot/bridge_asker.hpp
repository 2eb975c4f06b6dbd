#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <multireach/bridge_request_t.hpp>
#include <multireach/bridge_state_t.hpp>
#include <optional>
#include <string>

namespace multireach {

/// What the bridge answered to a request of a user.
struct BridgeAnswer {
  std::string word;  ///< what was asked for, e.g. "pause"
  bool accepted = false;
  std::string state;    ///< the bridge's, in words; "" when it did not answer
  std::string problem;  ///< "" when there is none

  /// Both in one line.
  std::string text() const { return problem + (problem.empty() || state.empty() ? "" : "; ") + state; }
};

/// Asks the bridge, one request after the other. A request to stop or to pause goes to every bridge, and at once. For
/// another, the bridge's run is asked first, and nothing is sent where two bridges answer; where it asks for motion,
/// the answer waits for ROBOT_STATE, without which nothing moves. A request is repeated until BRIDGE_STATE answers it,
/// and given up after two seconds. Knows time only from its arguments.
class BridgeAsker {
 public:
  /// How long others may answer after the first one did, microseconds.
  static constexpr int64_t kOthersAnswer = 250000;
  /// How often tick() must be called at least, microseconds.
  static constexpr int64_t kTickUs = 20000;
  /// A robot that sends nothing for so long is not there, microseconds.
  static constexpr int64_t kRobotTime = 500000;

  /// `first_request`: number of the first request; random, so that several askers differ.
  explicit BridgeAsker(int64_t first_request) : next_request_(first_request) {}

  /// Queues a request. One to stop or to pause goes first, and replaces all that wait: nothing that was asked before a
  /// stop may follow it.
  void ask(const std::string& word, int8_t kind, double speed = 0);
  void receive(const bridge_state_t& state);
  /// A ROBOT_STATE has arrived.
  void receive_robot_state() { robot_heard_ = true; }
  /// The request to send now, if any. `now_us`: time, microseconds.
  std::optional<bridge_request_t> tick(int64_t now_us);
  std::optional<BridgeAnswer> take_answer();

 private:
  static constexpr int64_t kTimeout = 2000000;      // us
  static constexpr int64_t kRepeatPeriod = 200000;  // us
  static constexpr size_t kMaxWaiting = 16;

  /// What is awaited.
  enum class Step {
    kBridges,  ///< which bridges there are, or the answers of all
    kAnswer,   ///< of the bridge that was asked
    kRobot,    ///< a ROBOT_STATE
    kResult,   ///< the bridge's state after it
  };
  struct Question {
    std::string word;
    int8_t kind = 0;
    double speed = 0;
  };

  void begin(Step step, int8_t kind, int64_t run);
  void advance(int64_t now_us);
  void conclude_bridges();
  void finish(bool accepted, const std::string& problem);

  int64_t next_request_;
  std::deque<Question> waiting_;  // the first one is being asked
  std::deque<BridgeAnswer> answers_;
  std::optional<Step> step_;  // of the first question, once begun
  bridge_request_t request_{};
  std::map<int64_t, bridge_state_t> states_;  // newest of each bridge, by run, that was heard in this step
  std::optional<int64_t> begun_us_, sent_us_, answered_us_;
  bool robot_heard_ = false;
  std::string state_;  // what the bridge said last
};

}  // namespace multireach
