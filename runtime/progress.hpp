#pragma once

#include <chrono>

namespace multireach {

/// A line on standard error that says how much of a long work is done and how long the rest may take. Silent where that
/// is no terminal.
class Progress {
 public:
  Progress();
  ~Progress() { end(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `part`: 0 to 1. Cheap: it writes a few times per second only.
  void show(double part);
  /// Removes the line.
  void end();

 private:
  bool terminal_, shown_ = false;
  std::chrono::steady_clock::time_point begin_, last_;
};

}  // namespace multireach
