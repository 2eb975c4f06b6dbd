// Lost, reordered and repeated messages of a log.
#include "tools/log/sequence_gaps.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <limits>

namespace multireach {
namespace {

SequenceGaps after(std::initializer_list<int64_t> numbers) {
  SequenceGaps gaps;
  int64_t utime = 0;
  for (const int64_t number : numbers) gaps.add(number, utime += 1000);
  return gaps;
}

TEST(SequenceGaps, AReorderedMessageIsNeitherLostNorDamaged) {
  for (const auto& numbers :
       {std::initializer_list<int64_t>{1, 2, 4, 3, 5, 6}, {1, 4, 3, 2, 5}, {1, 3, 4, 5, 6, 2, 7}}) {
    const SequenceGaps gaps = after(numbers);
    EXPECT_EQ(gaps.lost(), 0);
    EXPECT_EQ(gaps.damaged(), 0);
    EXPECT_EQ(gaps.restarts(), 0);
  }
}

TEST(SequenceGaps, WhatNeverComesIsLostOnce) {
  const SequenceGaps gaps = after({1, 2, 5, 4, 6, 7, 9});
  EXPECT_EQ(gaps.lost(), 2) << "3 and 8";
  EXPECT_EQ(gaps.damaged(), 0);
}

TEST(SequenceGaps, ARepeatedMessageHealsNoLoss) {
  const SequenceGaps gaps = after({1, 3, 3, 4, 5});
  EXPECT_EQ(gaps.lost(), 1);
  EXPECT_EQ(gaps.damaged(), 1) << "the repetition";
}

TEST(SequenceGaps, NumbersOfAnySizeAreDamage) {
  using Limits = std::numeric_limits<int64_t>;
  const SequenceGaps gaps = after({5, Limits::min(), 6, Limits::max(), 7, Limits::min() + 46, -1, 8});
  EXPECT_EQ(gaps.lost(), 0);
  EXPECT_EQ(gaps.damaged(), 4);
  EXPECT_EQ(gaps.restarts(), 0);
}

}  // namespace
}  // namespace multireach
