#pragma once

#include <array>
#include <deque>
#include <optional>
#include <vector>

#include "camera/pairing/frame.hpp"

namespace multireach {

enum class Side { kLeft = 0, kRight = 1 };

/// Left and right frames of two cameras that run freely, made into pairs by their times of capture.
///
/// A frame is paired with the one nearest in time of the other side, when they are at most `max_skew_us` apart. Where
/// the other side's next frame may still be nearer, judged by that side's own period lately, it is waited for. A frame
/// that can no longer get a partner is dropped and counted.
class FramePairing {
 public:
  struct Pair {
    Frame left, right;
  };
  /// Frames of a side that wait for the other side; when there are more, the oldest is dropped.
  static constexpr size_t kDeepest = 8;

  /// `period_us`: of both cameras, as configured. Throws std::invalid_argument when it is not positive, or when
  /// `max_skew_us` is negative.
  FramePairing(int64_t period_us, int64_t max_skew_us);

  /// The pairs that this frame completes, oldest first. A frame whose time is not later than that of the last of its
  /// side is dropped.
  std::vector<Pair> add(Side side, Frame frame);
  /// A side has stopped, for the time being: what waits for it is dropped, and its period is to be learnt anew.
  void forget(Side side);

  size_t waiting(Side side) const { return queue(side).size(); }
  int64_t unpaired() const { return unpaired_; }  ///< frames dropped so far
  int64_t max_skew_us() const { return max_skew_us_; }
  int64_t period_us() const { return nominal_period_us_; }

 private:
  const std::deque<Frame>& queue(Side side) const { return queues_[static_cast<size_t>(side)]; }
  std::deque<Frame>& queue(Side side) { return queues_[static_cast<size_t>(side)]; }
  void drop_front(Side side);
  void learn_period(Side side, int64_t interval_us);
  std::optional<Pair> next_pair();

  int64_t nominal_period_us_, max_skew_us_;
  std::array<std::deque<Frame>, 2> queues_;
  std::array<std::optional<int64_t>, 2> newest_;
  std::array<int64_t, 2> period_us_;
  int64_t unpaired_ = 0;
};

}  // namespace multireach
