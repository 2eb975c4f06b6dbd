#pragma once

#include <array>
#include <deque>
#include <optional>
#include <vector>

#include "camera/pairing/frame.hpp"
#include "imaging/side.hpp"

namespace multireach {

/// Pairs the left and right frames of two unsynchronised cameras by time of capture.
///
/// A frame is paired with the frame of the other camera that is nearest in time, if they are at most `max_skew_us`
/// apart. If that camera's next frame could be nearer still, judged by its recent frame period, the pairing waits for
/// it. Frames that can no longer be paired are dropped and counted.
class FramePairing {
 public:
  struct Pair {
    Frame left, right;
  };
  /// Most frames of one side that wait for the other; beyond that, the oldest is dropped.
  static constexpr size_t kMaxQueue = 8;

  /// `period_us`: the configured frame period of both cameras. Throws std::invalid_argument when it is not positive, or
  /// when `max_skew_us` is negative.
  FramePairing(int64_t period_us, int64_t max_skew_us);

  /// The pairs that this frame completes, oldest first. A frame that is not later than the last one of its side is
  /// dropped.
  std::vector<Pair> add(Side side, Frame frame);
  /// Call when a camera has stopped: drops its waiting frames and resets its estimated period.
  void reset(Side side);

  size_t waiting(Side side) const { return queue(side).size(); }
  int64_t unpaired() const { return unpaired_; }  ///< frames dropped so far
  int64_t max_skew_us() const { return max_skew_us_; }
  int64_t period_us() const { return nominal_period_us_; }

 private:
  const std::deque<Frame>& queue(Side side) const { return queues_[index(side)]; }
  std::deque<Frame>& queue(Side side) { return queues_[index(side)]; }
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
