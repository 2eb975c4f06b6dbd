#pragma once

#include <map>
#include <multireach/bridge_state_t.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace multireach {

/// When and why the bridge did not let the robot move, by its BRIDGE_STATE.
class BridgeHalts {
 public:
  void add(const bridge_state_t& state) {
    using State = bridge_state_t;
    Phase& phase = phases_[state.run];
    const Phase before = phase;
    const bool stops = state.state == State::STOPPING || (state.state == State::IDLE && before != Phase::kNew);
    const bool pauses = !state.cause.empty() && (state.state == State::ARMED || state.state == State::RUNNING);
    phase = state.state == State::FAULT  ? Phase::kFault
            : stops || pauses            ? Phase::kStopped
            : state.state == State::IDLE ? before
                                         : Phase::kMoves;
    if (phase == Phase::kFault && before != Phase::kFault) faults_.push_back({state.utime, state.cause});
    if (phase == Phase::kStopped && before == Phase::kMoves)
      stops_.push_back({state.utime, state.cause.empty() ? "disabled" : state.cause});
  }

  /// Lists of `at_s`, message time since `origin`, and `cause`.
  nlohmann::json faults_to_json(int64_t origin) const { return to_json(faults_, origin, INT64_MAX); }
  /// Stops and pauses up to `end`.
  nlohmann::json stops_to_json(int64_t origin, int64_t end) const { return to_json(stops_, origin, end); }

 private:
  enum class Phase { kNew, kMoves, kStopped, kFault };
  struct Halt {
    int64_t utime;  ///< message time of the first state that says so
    std::string cause;
  };

  static nlohmann::json to_json(const std::vector<Halt>& halts, int64_t origin, int64_t end) {
    nlohmann::json list = nlohmann::json::array();
    for (const Halt& halt : halts) {
      if (halt.utime > end) continue;
      list.push_back({{"at_s", static_cast<double>(halt.utime - origin) * 1e-6}, {"cause", halt.cause}});
    }
    return list;
  }

  std::map<int64_t, Phase> phases_;  // by the bridge's run
  std::vector<Halt> faults_, stops_;
};

}  // namespace multireach
