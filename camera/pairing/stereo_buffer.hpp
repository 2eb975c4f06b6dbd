#pragma once

#include <array>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>

#include "camera/pairing/frame_pairing.hpp"
#include "camera/pairing/skew_statistics.hpp"

namespace multireach {

/// Passes frames from the camera threads to the node, as pairs. Thread-safe.
class StereoBuffer {
 public:
  explicit StereoBuffer(FramePairing pairing) : pairing_(std::move(pairing)) {}

  /// Adds a frame of one side.
  void push(Side side, Frame frame);
  /// Waits up to `timeout_us` until the side has room for a frame; returns whether it has.
  [[nodiscard]] bool wait_for_room(Side side, int64_t timeout_us);
  /// Sets the side's fault for NODE_STATUS; "" for none.
  void set_fault(Side side, std::string fault);
  /// The side's device was closed and may be reopened.
  void reset(Side side);
  /// The side will deliver no more frames.
  void end(Side side);
  /// The program cannot go on, for the reason in this sentence.
  void fail(std::string sentence);

  /// Waits at most `timeout_us` for the next pair. Throws std::runtime_error with the sentence of `fail` once there are
  /// no more pairs.
  std::optional<FramePairing::Pair> pop(int64_t timeout_us);
  /// Whether there will be no more pairs.
  bool ended() const;
  /// State text for NODE_STATUS at time `utime` of the capture clock.
  std::string state(int64_t utime) const;

 private:
  bool has_room(Side side) const;
  bool finished() const;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  FramePairing pairing_;
  SkewStatistics skew_;
  std::deque<FramePairing::Pair> pairs_;
  std::array<std::string, 2> fault_;
  std::string failure_;
  std::array<bool, 2> ended_{};
  int64_t unsent_ = 0;  // pairs dropped because they were not fetched in time
  std::optional<int64_t> newest_pair_, first_frame_;
};

}  // namespace multireach
