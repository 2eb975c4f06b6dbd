#pragma once

#include <array>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>

#include "camera/pairing/frame_pairing.hpp"
#include "camera/pairing/skew_statistics.hpp"

namespace multireach {

/// Where the threads of the cameras put their frames, and the node takes its pairs. Safe to use from several threads.
class StereoBuffer {
 public:
  explicit StereoBuffer(FramePairing pairing) : pairing_(std::move(pairing)) {}

  /// A camera works again from here on.
  void put(Side side, Frame frame);
  /// Returns when the side has room for a frame, at the latest after `timeout_us`; true when it has.
  bool wait_for_room(Side side, int64_t timeout_us);
  /// What is wrong with a side, as NODE_STATUS shall say it; "" when nothing is.
  void set_trouble(Side side, std::string trouble);
  /// A side was closed and may come again.
  void forget(Side side);
  /// A side will never give a frame again.
  void end(Side side);

  /// Waits at most `timeout_us` for the next pair.
  std::optional<FramePairing::Pair> take(int64_t timeout_us);
  /// Whether there will be no more pairs.
  bool ended() const;
  /// For NODE_STATUS, at the time `utime` of the capture clock.
  std::string state(int64_t utime) const;

 private:
  bool room(Side side) const;
  bool over() const;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  FramePairing pairing_;
  SkewStatistics skew_;
  std::deque<FramePairing::Pair> pairs_;
  std::array<std::string, 2> trouble_;
  std::array<bool, 2> ended_{};
  int64_t unsent_ = 0;  // pairs that nobody took in time
  std::optional<int64_t> newest_pair_, first_frame_;
};

}  // namespace multireach
