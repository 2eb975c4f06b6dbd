#include "camera/pairing/skew_statistics.hpp"

#include <algorithm>
#include <cstdlib>
#include <vector>

namespace multireach {
namespace {

constexpr int64_t kSecond = 1000000;  // us

}  // namespace

void SkewStatistics::add(int64_t utime, int64_t skew_us) {
  entries_.push_back({utime, skew_us});
  while (entries_.front().utime <= utime - kSecond) entries_.pop_front();
}

std::optional<SkewStatistics::Summary> SkewStatistics::last_second() const {
  if (entries_.empty()) return std::nullopt;
  Summary summary{.pairs = static_cast<int64_t>(entries_.size())};
  std::vector<int64_t> skews;
  for (const Entry& entry : entries_) {
    skews.push_back(entry.skew_us);
    summary.max_us = std::max(summary.max_us, std::abs(entry.skew_us));
  }
  const auto middle = skews.begin() + static_cast<std::ptrdiff_t>(skews.size() / 2);
  std::ranges::nth_element(skews, middle);
  summary.median_us = *middle;
  return summary;
}

}  // namespace multireach
