#include "tools/robot/bridge_asker.hpp"

#include <algorithm>

#include "tools/robot/bridge_words.hpp"

namespace multireach {

void BridgeAsker::ask(const std::string& word, int8_t kind, double speed) {
  if (asks_all(kind)) {
    waiting_.clear();
    step_.reset();
  }
  if (waiting_.size() >= kMaxWaiting) {
    answers_.push_back({word, false, "", "too many requests wait for the bridge"});
    return;
  }
  waiting_.push_back({word, kind, speed});
}

void BridgeAsker::begin(Step step, int8_t kind, int64_t run) {
  step_ = step;
  request_ = bridge_request_t{};
  request_.kind = kind;
  request_.run = run;
  request_.request = next_request_++;
  if (kind == bridge_request_t::SPEED) request_.speed = waiting_.front().speed;
  states_.clear();
  begun_us_.reset();
  sent_us_.reset();
  answered_us_.reset();
}

void BridgeAsker::finish(bool accepted, const std::string& problem) {
  answers_.push_back({waiting_.front().word, accepted, state_, problem});
  waiting_.pop_front();
  step_.reset();
}

void BridgeAsker::receive(const bridge_state_t& state) {
  if (!step_) return;
  bridge_state_t& newest = states_[state.run];
  const bool answered = newest.request == request_.request && request_.request != 0;
  if (!answered || state.request == request_.request) newest = state;  // other askers ask, too
}

/// All bridges had time to answer.
void BridgeAsker::conclude_bridges() {
  const Question& question = waiting_.front();
  bool accepted = true, complete = true;
  state_.clear();
  for (const auto& [run, state] : states_) {
    const bool answers = state.request == request_.request;
    state_ += (state_.empty() ? "" : "; ") + text_of(state);
    complete = complete && answers;
    accepted = accepted && (!answers || state.request_accepted);
  }
  const bool only_asks = question.kind == bridge_request_t::STATUS || asks_all(question.kind);
  if (only_asks) {
    return finish(accepted && complete, !accepted   ? refusal_of(question.kind)
                                        : !complete ? "a bridge did not answer: ask again"
                                                    : "");
  }
  if (states_.size() > 1) {
    return finish(
        false, std::to_string(states_.size()) + " bridges answer, so nothing was sent to any of them: end all but one");
  }
  begin(Step::kAnswer, question.kind, states_.begin()->first);
}

/// Goes to the next step where this one is complete.
void BridgeAsker::advance(int64_t now_us) {
  const auto answers = [&](const auto& each) { return each.second.request == request_.request; };
  const auto answer = std::find_if(states_.begin(), states_.end(), answers);
  if (answer != states_.end() && !answered_us_) answered_us_ = now_us;
  switch (*step_) {
    case Step::kBridges:
      if (answered_us_ && now_us - *answered_us_ >= kOthersAnswer) conclude_bridges();
      return;
    case Step::kAnswer: {
      const int8_t kind = waiting_.front().kind;
      if (answer == states_.end()) return;
      state_ = text_of(answer->second);
      if (!answer->second.request_accepted) return finish(false, refusal_of(kind));
      if (!asks_to_move(kind)) return finish(true, "");
      robot_heard_ = false;
      return begin(Step::kRobot, bridge_request_t::STATUS, 0);
    }
    case Step::kRobot:
      if (robot_heard_) return begin(Step::kResult, bridge_request_t::STATUS, 0);
      if (begun_us_ && now_us - *begun_us_ >= kRobotTime)
        finish(false, "no ROBOT_STATE arrives, so nothing moves; is the robot, or its driver, running?");
      return;
    case Step::kResult: {
      if (answer == states_.end()) return;
      state_ = text_of(answer->second);
      const std::string hindrance = hindrance_of(waiting_.front().kind, answer->second);
      return finish(hindrance.empty(), hindrance);
    }
  }
}

std::optional<bridge_request_t> BridgeAsker::tick(int64_t now_us) {
  if (waiting_.empty()) return std::nullopt;
  const int8_t kind = waiting_.front().kind;
  if (!step_) begin(Step::kBridges, asks_all(kind) ? kind : bridge_request_t::STATUS, bridge_request_t::ALL);
  if (!begun_us_) begun_us_ = now_us;
  advance(now_us);
  if (!step_) return std::nullopt;
  if (!begun_us_) begun_us_ = now_us;  // of the next step
  if (!answered_us_ && now_us - *begun_us_ > kTimeout) {
    state_.clear();
    finish(false, "no answer; is multireach-bridge running on this LCM group, with the same --key?");
    return std::nullopt;
  }
  const bool repeats = *step_ != Step::kRobot && !(answered_us_ && *step_ != Step::kBridges);
  if (!repeats || (sent_us_ && now_us - *sent_us_ < kRepeatPeriod)) return std::nullopt;
  sent_us_ = now_us;
  request_.utime = now_us;
  return request_;
}

std::optional<BridgeAnswer> BridgeAsker::take_answer() {
  if (answers_.empty()) return std::nullopt;
  BridgeAnswer answer = std::move(answers_.front());
  answers_.pop_front();
  return answer;
}

}  // namespace multireach
