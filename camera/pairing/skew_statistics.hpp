#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace multireach {

/// How far apart in time the two images of the pairs of the last second were.
class SkewStatistics {
 public:
  struct Summary {
    int64_t median_us = 0;  ///< right - left
    int64_t max_us = 0;     ///< without sign
    int64_t pairs = 0;
  };

  /// `utime`: of the pair, not decreasing; `skew_us`: capture time of right - left.
  void add(int64_t utime, int64_t skew_us);
  /// Of the second that ends with the newest pair; nothing before the first.
  std::optional<Summary> last_second() const;

 private:
  struct Entry {
    int64_t utime, skew_us;
  };
  std::deque<Entry> entries_;
};

}  // namespace multireach
