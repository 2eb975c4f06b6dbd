// How multireach-bench-real counts answers to labels.
#include "bench/real/score.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace multireach::bench {
namespace {

TEST(Score, CountsWhatIsRightAndWrongByTheDistance) {
  Score score;
  score.add({{100, 110}}, {{100, 100}}, 1);  // 10 px
  score.add({{100, 111}}, {{100, 100}}, 1);
  score.add({{100, 126}}, {{100, 100}}, 1);
  score.add({}, {{100, 100}}, 1);
  EXPECT_EQ(score.labelled, 4);
  EXPECT_EQ(score.right, 1);
  EXPECT_EQ(score.wrong, 1) << "at 11 px an answer is neither";
  EXPECT_EQ(score.errors_px, (std::vector<double>{10, 11}));
  score.add_without_label({{3, 4}});
  score.add_without_label({});
  EXPECT_EQ(score.without, 2);
  EXPECT_EQ(score.answered_without, 1);
  Score sum = score;
  sum.add(score);
  EXPECT_EQ(sum.labelled, 8);
  EXPECT_EQ(sum.right, 2);
  EXPECT_EQ(sum.median_px(), 11);
}

TEST(Score, AnAnswerBelongsToOneLabel) {
  Score one;
  one.add({{105, 100}}, {{100, 100}, {112, 100}}, 2);
  EXPECT_EQ(one.labelled, 2);
  EXPECT_EQ(one.right, 1) << "both labels are within 10 px of the answer";
  EXPECT_EQ(one.wrong, 0);
  // The nearest first: the second answer is nearer to the first label than its own is.
  const auto answered = answered_labels({{100, 100}, {112, 100}}, {{110, 100}, {101, 100}}, 2);
  EXPECT_EQ(answered[0].error_px, 1);
  EXPECT_EQ(answered[1].error_px, 2);
}

TEST(Score, OfThingsThatLookAlikeAsManyCountAsAreLookedFor) {
  const std::vector<cv::Point2d> labels{{10, 10}, {200, 10}, {400, 10}};
  Score score;
  score.add({{201, 10}}, labels, 1);
  EXPECT_EQ(score.labelled, 1) << "any of them is right";
  EXPECT_EQ(score.right, 1);
  score.add({{201, 10}, {300, 10}}, labels, 2);
  EXPECT_EQ(score.labelled, 3);
  EXPECT_EQ(score.right, 2);
  EXPECT_EQ(score.wrong, 1);
  EXPECT_TRUE(std::isinf(answered_labels(labels, {}, 3)[0].error_px));
}

}  // namespace
}  // namespace multireach::bench
