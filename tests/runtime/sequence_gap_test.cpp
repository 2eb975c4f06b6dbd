// Which messages count as lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "numeric/random.hpp"
#include "runtime/node.hpp"

namespace multireach {
namespace {

TEST(SequenceGapCounter, ANumberIsLostOnce64LaterOnesCame) {
  SequenceGapCounter gaps;
  EXPECT_EQ(gaps.newly_lost(10), 0) << "what came before is not this counter's loss";
  EXPECT_EQ(gaps.newly_lost(12), 0);
  for (int64_t k = 13; k < 11 + 64; ++k) EXPECT_EQ(gaps.newly_lost(k), 0) << k;
  EXPECT_EQ(gaps.newly_lost(11 + 64), 1);
  EXPECT_EQ(gaps.newly_lost(11 + 65), 0);
}

TEST(SequenceGapCounter, AReorderedOrRepeatedMessageIsNotLost) {
  SequenceGapCounter gaps;
  int64_t lost = 0;
  for (int64_t k = 0; k < 1000; k += 2) {
    for (const int64_t number : {k + 1, k, k, k + 1}) lost += gaps.newly_lost(number);
  }
  EXPECT_EQ(lost, 0);
  EXPECT_EQ(gaps.newly_lost(3), 0) << "very late";
  for (int64_t k = 1000; k < 1200; ++k) lost += gaps.newly_lost(k);
  EXPECT_EQ(lost, 0);
}

// Random losses, delays of up to 50 messages and repetitions, against the set of what arrived.
TEST(SequenceGapCounter, CountsEachLostMessageOnce) {
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const CounterRandom random(seed);
    uint64_t counter = 0;
    const auto number = [&](double end) { return random.uniform(counter++, 0, end); };
    std::vector<std::pair<double, int64_t>> arrivals;
    constexpr int64_t kNumbers = 3000;
    for (int64_t k = 0; k < kNumbers; ++k) {
      const bool edge = k == 0 || k >= kNumbers - 100;
      if (!edge && number(1) < 0.05) continue;
      for (int copy = number(1) < 0.1 ? 2 : 1; copy > 0; --copy)
        arrivals.emplace_back(static_cast<double>(k) + (edge ? 0 : number(50)), k);
    }
    std::ranges::sort(arrivals);
    SequenceGapCounter gaps;
    std::set<int64_t> arrived;
    int64_t lost = 0;
    for (const auto& [time, k] : arrivals) {
      const int64_t newly = gaps.newly_lost(k);
      EXPECT_GE(newly, 0);
      lost += newly;
      arrived.insert(k);
    }
    // The newest 64 are still awaited; they all arrived.
    EXPECT_EQ(lost, kNumbers - static_cast<int64_t>(arrived.size()));
  }
}

TEST(SequenceGapCounter, ALongGapIsALossARestartIsNone) {
  SequenceGapCounter gaps;
  (void)gaps.newly_lost(0);
  EXPECT_EQ(gaps.newly_lost(5000), 0) << "it may be a damaged number";
  int64_t lost = 0;
  for (int64_t k = 5001; k < 5100; ++k) lost += gaps.newly_lost(k);
  EXPECT_EQ(lost, 4999);
  for (int64_t k = 7; k < 200; ++k) lost += gaps.newly_lost(k);
  EXPECT_EQ(lost, 4999) << "restarted";
  lost += gaps.newly_lost(7000);  // damaged
  for (int64_t k = 200; k < 300; ++k) lost += gaps.newly_lost(k);
  EXPECT_EQ(lost, 4999);
  EXPECT_EQ(gaps.newly_lost(400, 2), 0) << "another publisher";
}

TEST(SequenceGapCounter, NoNumberOverflows) {
  SequenceGapCounter gaps;
  int64_t lost = 0;
  for (const int64_t number :
       {int64_t{0}, INT64_MAX, INT64_MAX - 1, INT64_MIN, int64_t{-1}, INT64_MAX, int64_t{1}, INT64_MAX}) {
    for (int64_t k = -2; k <= 2; ++k) {
      const int64_t newly =
          gaps.newly_lost(static_cast<int64_t>(static_cast<uint64_t>(number) + static_cast<uint64_t>(k)));
      EXPECT_GE(newly, 0);
      lost += newly;
    }
  }
  EXPECT_LT(lost, int64_t{1} << 36);
}

}  // namespace
}  // namespace multireach
