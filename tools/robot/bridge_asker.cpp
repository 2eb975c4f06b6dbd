#include "tools/page/bridge_asker.hpp"

#include "tools/robot/bridge_words.hpp"

namespace multireach {

void BridgeAsker::ask(const std::string& word, int8_t kind, double speed) {
  if (kind == bridge_request_t::DISABLE) {
    waiting_.clear();
    begun_us_.reset();
    sent_us_.reset();
  }
  if (waiting_.size() >= kMaxWaiting) {
    answers_.push_back({word, false, "too many requests wait for the bridge"});
    return;
  }
  bridge_request_t request{};
  request.kind = kind;
  request.speed = speed;
  number(request);
  waiting_.push_back({word, request});
}

void BridgeAsker::finish(bool accepted, const std::string& text) {
  answers_.push_back({waiting_.front().word, accepted, text});
  waiting_.pop_front();
  begun_us_.reset();
  sent_us_.reset();
}

void BridgeAsker::receive(const bridge_state_t& state) {
  const bool other_bridge = run_ != state.run;
  run_ = state.run;
  if (waiting_.empty()) return;
  bridge_request_t& request = waiting_.front().request;
  const bool answers = state.request == request.request;
  if (other_bridge && (!answers || !state.request_accepted)) {  // it was asked for the bridge of before, or not yet
    number(request);
    sent_us_.reset();
    return;
  }
  if (!answers) return;
  std::string text = text_of(state);
  if (!state.request_accepted) text = refusal_of(request.kind) + "; " + text;
  finish(state.request_accepted, text);
}

std::optional<bridge_request_t> BridgeAsker::tick(int64_t now_us) {
  if (waiting_.empty()) return std::nullopt;
  if (!begun_us_) begun_us_ = now_us;
  if (now_us - *begun_us_ > kTimeout) {
    finish(false, "no answer; is the bridge running?");
    return std::nullopt;
  }
  if (sent_us_ && now_us - *sent_us_ < kRepeatPeriod) return std::nullopt;
  sent_us_ = now_us;
  bridge_request_t request = waiting_.front().request;
  if (!run_) {
    request = bridge_request_t{};
    request.kind = bridge_request_t::STATUS;
    number(request);
  } else {
    request.run = run_asked(request.kind, *run_);
  }
  request.utime = now_us;
  return request;
}

std::optional<BridgeAnswer> BridgeAsker::take_answer() {
  if (answers_.empty()) return std::nullopt;
  BridgeAnswer answer = std::move(answers_.front());
  answers_.pop_front();
  return answer;
}

}  // namespace multireach
