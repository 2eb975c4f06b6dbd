#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace multireach {

/// Time differences between left and right images, over the pairs of the last second.
class SkewStatistics {
 public:
  struct Summary {
    int64_t median_us = 0;  ///< signed: right - left
    int64_t max_us = 0;     ///< largest absolute value
    int64_t pairs = 0;
  };

  /// `utime`: time of the pair, must not decrease; `skew_us`: capture time of right - left.
  void add(int64_t utime, int64_t skew_us);
  /// Statistics of the second that ends with the newest pair; nothing before the first pair.
  std::optional<Summary> last_second() const;

 private:
  struct Entry {
    int64_t utime, skew_us;
  };
  std::deque<Entry> entries_;
};

}  // namespace multireach
