#pragma once

#include <cstdint>
#include <optional>

namespace multireach {

/// Judges the consecutive numbers of one counter in a log: lost messages, restarts of the counter, and numbers that are
/// damaged or of a second publisher. A message that comes up to 64 numbers late was reordered, which is neither a loss
/// nor damage. A step forward is a loss only where the time that it took could hold as many messages. Another step is a
/// restart if the counter then continues from there, and else a number that does not fit.
class SequenceGaps {
 public:
  /// `first`: the number that the counter begins with, where that is known.
  explicit SequenceGaps(std::optional<int64_t> first = std::nullopt) : expected_(first) {}

  /// `utime`: time of receipt, microseconds.
  void add(int64_t number, int64_t utime);
  /// Numbers missing before this one, if it were the next; 0 where it is no plausible loss.
  int64_t missing_before(int64_t number, int64_t utime) const;

  bool started() const { return expected_.has_value(); }
  int64_t lost() const { return lost_; }
  int64_t restarts() const { return restarts_; }
  int64_t damaged() const { return damaged_; }

 private:
  /// Whether `number` may come next where `expected` would, were nothing lost.
  bool continues(int64_t expected, int64_t number, int64_t utime) const;
  bool was_reordered(int64_t number);
  void expect_after(int64_t number);

  std::optional<int64_t> expected_;  // the next number, if nothing is lost
  std::optional<int64_t> unsure_;    // the same after a number that did not fit
  uint64_t arrived_ = ~uint64_t{0};  // bit k: whether the number expected_ - 1 - k has come
  int64_t misfits_ = 0;              // numbers since `expected_` that did not fit: messages that are not lost
  std::optional<int64_t> last_utime_;
  int64_t lost_ = 0, restarts_ = 0, damaged_ = 0;
};

/// The difference of two times of a log that may be damaged: 0 where one of them is not plausible.
int64_t time_between(int64_t from_utime, int64_t to_utime);

}  // namespace multireach
