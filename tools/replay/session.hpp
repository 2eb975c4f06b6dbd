#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "runtime/log_file.hpp"

namespace multireach {

/// Which inputs a replay takes from a recorded session; everything else is computed again.
enum class ReplayFrom { kImages, kTargets };

/// One input of a replay.
struct SessionInput {
  int64_t at_us = 0;  ///< replay time, 0 at the first input
  std::string_view channel;
  std::span<const uint8_t> data;
};

/// The inputs in a log, with their replay times. Images and targets carry the camera's time and keep its intervals.
/// Where the camera's time goes back or jumps by more than a second (a log that was played twice, another camera), and
/// for all other messages, the recorder's clock gives the interval since the previous message.
class Session {
 public:
  /// Throws InputError when the log cannot be read.
  Session(const std::string& path, ReplayFrom from, bool with_robot_states);

  /// The next input; nothing at the end. Its views are valid as long as the session.
  std::optional<SessionInput> next();
  void rewind();
  /// Time of receipt of the first input, wall clock, microseconds; 0 if there is none.
  int64_t recorded_utime() const { return recorded_utime_; }
  const LogReader& log() const { return log_; }

 private:
  bool wanted(std::string_view channel) const;
  /// Reads ahead to the next message with a camera time, but at most one second.
  bool read_ahead();
  int64_t time_since_previous(const LogEvent& event) const;
  int64_t time_of(const LogEvent& event, int64_t camera_utime) const;

  LogReader log_;
  std::deque<LogEvent> waiting_;
  std::vector<std::string_view> channels_;
  int64_t recorded_utime_ = 0;
  int64_t now_us_ = 0;
  std::optional<int64_t> event_utime_;               // previous input, recorder's clock
  std::optional<int64_t> camera_utime_, camera_at_;  // previous image, camera's clock and replay time
};

/// kImages if the log holds images, else kTargets. Throws InputError when it has neither.
ReplayFrom replay_source(const std::string& path);

}  // namespace multireach
