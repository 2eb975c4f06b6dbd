#include "camera/pairing/frame_pairing.hpp"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace multireach {
namespace {

Side other(Side side) {
  return side == Side::kLeft ? Side::kRight : Side::kLeft;
}

}  // namespace

FramePairing::FramePairing(int64_t period_us, int64_t max_skew_us)
    : nominal_period_us_(period_us), max_skew_us_(max_skew_us), period_us_{period_us, period_us} {
  if (period_us <= 0) throw std::invalid_argument("the period of the frames must be positive");
  if (max_skew_us < 0) throw std::invalid_argument("the largest skew of a pair must not be negative");
}

void FramePairing::drop_front(Side side) {
  queue(side).pop_front();
  ++unpaired_;
}

void FramePairing::learn_period(Side side, int64_t interval_us) {
  int64_t& period = period_us_[index(side)];
  // Missing frames lengthen an interval and hardly anything shortens one, so the estimate follows short intervals
  // quickly and long ones slowly.
  period += (interval_us - period) / (interval_us < period ? 2 : 8);
  period = std::clamp(period, nominal_period_us_ / 8, 8 * nominal_period_us_);
}

std::vector<FramePairing::Pair> FramePairing::add(Side side, Frame frame) {
  std::optional<int64_t>& newest = newest_[index(side)];
  if (newest && frame.utime <= *newest) {
    ++unpaired_;
    return {};
  }
  if (newest) learn_period(side, frame.utime - *newest);
  newest = frame.utime;
  queue(side).push_back(std::move(frame));

  std::vector<Pair> pairs;
  while (auto pair = next_pair()) pairs.push_back(std::move(*pair));
  if (queue(side).size() > kMaxQueue) drop_front(side);
  return pairs;
}

void FramePairing::reset(Side side) {
  while (!queue(side).empty()) drop_front(side);
  newest_[index(side)].reset();
  period_us_[index(side)] = nominal_period_us_;
}

std::optional<FramePairing::Pair> FramePairing::next_pair() {
  std::deque<Frame>&left = queue(Side::kLeft), &right = queue(Side::kRight);
  while (!left.empty() && !right.empty()) {
    const Side early = left.front().utime <= right.front().utime ? Side::kLeft : Side::kRight;
    const std::deque<Frame>& before = queue(early);
    const std::deque<Frame>& after = queue(other(early));
    const int64_t late_utime = after.front().utime, period = period_us_[index(early)];
    const int64_t skew = late_utime - before.front().utime;
    if (skew > max_skew_us_) {
      drop_front(early);
      continue;
    }
    if (before.size() > 1) {
      if (std::abs(before[1].utime - late_utime) < skew) {
        drop_front(early);
        continue;
      }
    } else if (2 * skew > period && after.back().utime < before.front().utime + 2 * period) {
      return std::nullopt;  // wait until the next frame of this side arrives or is overdue
    }
    Pair pair{std::move(left.front()), std::move(right.front())};
    left.pop_front();
    right.pop_front();
    return pair;
  }
  return std::nullopt;
}

}  // namespace multireach
