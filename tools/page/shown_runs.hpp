#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tools/page/log_index.hpp"
#include "tools/page/run_comparison.hpp"

namespace multireach {

/// The runs that the page can show: a recorded log, other logs of the same session, and what a replay computes from the
/// log with other values. Logs are compared and replays computed one after the other in a thread of their own.
class ShownRuns {
 public:
  struct Options {
    std::string log;
    std::string robot;   ///< robot.yaml or its folder
    std::string vision;  ///< vision.yaml; "": as multireach-replay chooses it
  };
  static constexpr int64_t kRecorded = 0;  ///< number of the log itself
  static constexpr size_t kMostRuns = 8;

  /// Throws InputError when the log cannot be read.
  explicit ShownRuns(Options options);
  ~ShownRuns();
  ShownRuns(const ShownRuns&) = delete;
  ShownRuns& operator=(const ShownRuns&) = delete;

  /// Adds another log. Throws InputError when it cannot be read.
  void add_log(const std::string& path);
  /// Computes the session again with other values of robot.yaml and vision.yaml, as KEY=VALUE. `robot_model`: ideal,
  /// sim or recorded, as of `multireach-replay run`. Throws InputError for a key or value that is wrong.
  void recompute(const std::vector<std::string>& set, const std::string& robot_model);
  /// Forgets a run; one that is being computed ends. The recorded log stays.
  void remove(int64_t id);

  struct View {
    std::shared_ptr<const LogIndex> log;
    int64_t offset_us = 0;  ///< from a time in the recorded log to one in this log
  };
  /// A run that is complete; nothing for any other number.
  std::optional<View> find(int64_t id) const;
  /// All runs, for the page: {"runs": [...]}.
  nlohmann::ordered_json json() const;
  /// Changes with `json()`.
  int64_t version() const;

 private:
  enum class State { kWaiting, kComputing, kReady, kFailed };
  struct Run {
    int64_t id = 0;
    std::string label;
    std::vector<std::string> set;
    std::string robot_model;
    State state = State::kWaiting;
    std::string doing, failure;
    double progress = 0;
    bool removed = false;
    std::shared_ptr<const LogIndex> log;
    std::optional<RunComparison> comparison;
    nlohmann::ordered_json figures;
  };
  struct Removed {};  // ends the work on a run

  std::shared_ptr<Run> add(std::string label);
  void work();
  void compute(Run& run);
  void compute_log(Run& run);
  void report(Run& run);
  /// Throws Removed when the run is no longer wanted.
  void show(Run& run, const char* doing, double progress);

  Options options_;
  std::string folder_;  // for logs that are computed
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::shared_ptr<Run>> runs_;
  std::deque<std::shared_ptr<Run>> waiting_;
  int64_t next_id_ = 0, version_ = 0;
  bool ending_ = false;
  std::thread worker_;
};

}  // namespace multireach
