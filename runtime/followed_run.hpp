#pragma once

#include <cstdint>
#include <optional>

namespace multireach {

/// Follows one publisher of a channel: a second one, e.g. an old log that is played, is refused while the first is
/// heard.
class FollowedRun {
 public:
  /// `silence_us`: a publisher that was not heard for this long has ended.
  explicit FollowedRun(int64_t silence_us = 1000000) : silence_us_(silence_us) {}

  /// Whether to accept a message of the publisher's run `run`. `now_us`: the receiver's time, by its ticks; nothing
  /// before they begin, when every publisher is accepted.
  [[nodiscard]] bool accepts(int64_t run, std::optional<int64_t> now_us) {
    if (!would_accept(run, now_us)) return false;
    follow(run, now_us);
    return true;
  }
  /// The same, without following it.
  bool would_accept(int64_t run, std::optional<int64_t> now_us) const {
    const bool heard = run_ && now_us && last_us_ && *now_us - *last_us_ < silence_us_ && *now_us >= *last_us_;
    return !heard || run == *run_;
  }
  void follow(int64_t run, std::optional<int64_t> now_us) {
    run_ = run;
    last_us_ = now_us;
  }

  /// The run that is followed; nothing before the first message.
  std::optional<int64_t> run() const { return run_; }

 private:
  int64_t silence_us_;
  std::optional<int64_t> run_, last_us_;
};

}  // namespace multireach
