#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/input_journal.hpp"
#include "runtime/log_file.hpp"

namespace multireach {

/// A message in a log that is verified.
struct RecordedMessage {
  int64_t event = 0;  ///< its number in the log, counted here
  int64_t digest = 0;
  int64_t sequence = -1;
  int64_t utime = 0;  ///< when it was recorded, wall clock, microseconds
  std::span<const uint8_t> bytes;
};

/// One run of a node, from start to end, as NODE_INPUTS tells it.
struct RecordedRun {
  std::string node;
  int64_t run = 0, config_digest = 0;
  int64_t first_event = 0;  ///< where the log first tells of it
  /// How many messages it had taken in before those that the log tells of.
  int64_t untold = 0;
  /// What it took in then, in order; nothing where the recorder lost the telling.
  std::vector<std::optional<ConsumedInput>> inputs;
};

/// A log, sorted for being verified. Reads the log once and keeps some 90 bytes for every message of a computed
/// channel; the messages themselves stay in the file.
class RecordedLog {
 public:
  /// `progress` is called with the part that is read, 0 to 1. Throws InputError when the log cannot be read.
  template <class ReportProgress>
  RecordedLog(const std::string& path, ReportProgress&& progress) : log_(path) {
    while (const auto event = log_.next()) {
      take(*event);
      progress(static_cast<double>(log_.position()) / static_cast<double>(log_.size()));
    }
    finish();
  }

  const std::vector<RecordedMessage>& messages(std::string_view channel) const;
  /// The runs of a node, in the order in which the log tells of them.
  std::vector<const RecordedRun*> runs(std::string_view node) const;
  /// The bytes of the message with this digest; empty where the log has none.
  std::span<const uint8_t> bytes_of(int64_t digest) const;
  /// Messages that carry a check of themselves and do not fit it, or contradict one another.
  const std::vector<std::pair<std::string, RecordedMessage>>& broken() const { return broken_; }
  /// How many messages of NODE_INPUTS or NODE_STATUS fit their checks.
  int64_t whole(std::string_view channel) const;
  /// When the first event was recorded, wall clock, microseconds.
  int64_t first_utime() const { return first_utime_; }
  /// The builds that the nodes say they are.
  const std::map<std::string, std::string>& builds() const { return builds_; }

 private:
  void take(const LogEvent& event);
  void take_inputs(const RecordedMessage& message);
  void take_status(const RecordedMessage& message);
  void finish();

  LogReader log_;
  int64_t events_ = 0, first_utime_ = 0;
  std::map<std::string, std::vector<RecordedMessage>, std::less<>> channels_;
  std::map<std::string, int64_t, std::less<>> whole_;
  std::vector<std::pair<int64_t, std::span<const uint8_t>>> by_digest_;
  std::map<std::pair<std::string, int64_t>, RecordedRun> runs_;
  std::vector<std::pair<std::string, RecordedMessage>> broken_;
  std::map<std::string, std::string> builds_;
};

}  // namespace multireach
