#pragma once

#include <chrono>

namespace multireach {

/// A progress line on standard error: the part done and the estimated time left. Silent when standard error is not a
/// terminal.
class Progress {
 public:
  Progress();
  ~Progress() { end(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `part`: 0 to 1. Cheap to call: the line is updated only a few times per second.
  void show(double part);
  /// Removes the line.
  void end();

 private:
  bool terminal_, shown_ = false;
  std::chrono::steady_clock::time_point begin_, last_;
};

}  // namespace multireach
