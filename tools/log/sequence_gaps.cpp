#include "tools/log/sequence_gaps.hpp"

#include <algorithm>

#include "runtime/node.hpp"

namespace multireach {
namespace {

constexpr int64_t kAlwaysPlausible = 1000;          // messages lost, however short the time
constexpr int64_t kLargestLoss = int64_t{1} << 40;  // keeps sums from overflowing
constexpr int64_t kWindow = 64;
constexpr int64_t kLargestNumber = int64_t{1} << 62;

}  // namespace

int64_t time_between(int64_t from_utime, int64_t to_utime) {
  return plausible_utime(from_utime) && plausible_utime(to_utime) ? to_utime - from_utime : 0;
}

bool SequenceGaps::continues(int64_t expected, int64_t number, int64_t utime) const {
  if (number < expected || number >= kLargestNumber) return false;
  // No publisher sends more than one message in a microsecond.
  const int64_t time = last_utime_ ? std::max<int64_t>(0, time_between(*last_utime_, utime)) : 0;
  return number - expected <= std::min(kAlwaysPlausible + time, kLargestLoss);
}

int64_t SequenceGaps::missing_before(int64_t number, int64_t utime) const {
  if (!expected_ || !continues(*expected_, number, utime)) return 0;
  return std::max<int64_t>(0, number - *expected_ - misfits_);
}

/// Whether a number that seemed lost has come late.
bool SequenceGaps::was_reordered(int64_t number) {
  if (number < 0) return false;
  const int64_t late = *expected_ - 1 - number;
  if (late < 0 || late >= kWindow || (arrived_ >> late & 1) != 0) return false;
  arrived_ |= uint64_t{1} << late;
  return true;
}

void SequenceGaps::expect_after(int64_t number) {
  const int64_t step = expected_ ? number + 1 - *expected_ : kWindow;
  arrived_ = step < kWindow ? arrived_ << step | 1 : 1;
  if (!expected_ || step < 0) arrived_ = ~uint64_t{0};
  expected_ = number + 1;
}

void SequenceGaps::add(int64_t number, int64_t utime) {
  const bool usable = number >= 0 && number < kLargestNumber;
  if (!expected_) {
    if (usable) expect_after(number);
    damaged_ += !usable;
  } else if (continues(*expected_, number, utime)) {
    lost_ += missing_before(number, utime);
    expect_after(number);
    unsure_.reset();
    misfits_ = 0;
  } else if (was_reordered(number)) {
    lost_ = std::max<int64_t>(0, lost_ - 1);
  } else if (unsure_ && continues(*unsure_, number, utime)) {
    // The number before did not fit, and this one continues it: the counter was restarted there.
    --damaged_;
    ++restarts_;
    lost_ += number - *unsure_;
    arrived_ = ~uint64_t{0};
    expected_ = number + 1;
    unsure_.reset();
    misfits_ = 0;
  } else {
    ++damaged_;
    unsure_ = usable ? std::optional(number + 1) : std::nullopt;
    ++misfits_;
  }
  last_utime_ = utime;
}

}  // namespace multireach
