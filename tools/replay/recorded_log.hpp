#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/input_journal.hpp"
#include "runtime/log_file.hpp"

namespace multireach {

/// A message in a log to be verified.
struct RecordedMessage {
  int64_t event = 0;  ///< index of the event in the log
  int64_t digest = 0;
  int64_t sequence = -1;
  int64_t utime = 0;  ///< time of recording, wall clock, microseconds
  std::span<const uint8_t> bytes;
};

/// One run of a node, from start to end, as recorded in NODE_INPUTS.
struct RecordedRun {
  std::string node;
  int64_t run = 0, config_digest = 0;
  int64_t sender_run = 0;   ///< `run` in the messages that the node sent
  int64_t first_event = 0;  ///< event of its first NODE_INPUTS
  /// Number of messages consumed before the first one that NODE_INPUTS lists.
  int64_t unlisted_inputs = 0;
  /// The inputs consumed from then on, in order; nothing where the recorder lost the NODE_INPUTS that lists them.
  std::vector<std::optional<ConsumedInput>> inputs;
};

/// A log, sorted for being verified. Reads the log once and keeps some 90 bytes for every message; the messages
/// themselves stay in the file.
class RecordedLog {
 public:
  /// `progress` is called with the part read, 0 to 1. Throws InputError when the log cannot be read.
  template <class ReportProgress>
  RecordedLog(const std::string& path, ReportProgress&& progress) : log_(path) {
    while (const auto event = log_.next()) {
      add(*event);
      progress(static_cast<double>(log_.position()) / static_cast<double>(log_.size()));
    }
    finish();
  }

  const std::vector<RecordedMessage>& messages(std::string_view channel) const;
  /// The runs of a node, in the order of their first NODE_INPUTS.
  std::vector<const RecordedRun*> runs(std::string_view node) const;
  /// The bytes of the message with this digest; empty if the log has none.
  std::span<const uint8_t> bytes_of(int64_t digest) const;
  /// NODE_INPUTS and NODE_STATUS messages whose field `check` does not match, or that contradict one another.
  const std::vector<std::pair<std::string, RecordedMessage>>& invalid_messages() const { return invalid_messages_; }
  /// How many messages of NODE_INPUTS, NODE_STATUS or SIM_STEP fit their checks.
  int64_t valid_count(std::string_view channel) const;
  /// Time of the first event, wall clock, microseconds.
  int64_t first_utime() const { return first_utime_; }
  /// The build of each node, from NODE_STATUS.
  const std::map<std::string, std::string>& builds() const { return builds_; }

 private:
  void add(const LogEvent& event);
  void add_inputs(const RecordedMessage& message);
  void add_status(const RecordedMessage& message);
  void finish();

  LogReader log_;
  int64_t events_ = 0, first_utime_ = 0;
  std::map<std::string, std::vector<RecordedMessage>, std::less<>> channels_;
  std::map<std::string, int64_t, std::less<>> valid_count_;
  std::vector<std::pair<int64_t, std::span<const uint8_t>>> by_digest_;
  std::map<std::pair<std::string, int64_t>, RecordedRun> runs_;
  std::vector<std::pair<std::string, RecordedMessage>> invalid_messages_;
  std::map<std::string, std::string> builds_;
};

}  // namespace multireach
