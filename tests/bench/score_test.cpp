// How multireach-bench-real counts answers to labels.
#include "bench/real/score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

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

// 1 m before a camera with f = 500 px that looks along x of W: 1 cm is 5 px. With the label's own 5 px, four standard
// deviations are 4 * sqrt(2) * 5 = 28.3 px where the answer has 1 cm, and 20 px where it has none.
TEST(Score, LabelsContradictAnAnswerByItsCovariance) {
  StereoRig rig = parallel_rig(640, 480, 500, 0.1);
  rig.left.cx = 320;
  rig.left.cy = 240;
  rig.X_WL.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // columns: right, down and forward in W
  rig.X_WL.translation() << 1, 2, 3;
  vision::PositionEstimate answer;
  answer.position << 2, 2, 3;
  answer.covariance.diagonal() << 1, 1e-4, 0;  // the distance tells nothing at the principal point
  const auto contradicted = [&](std::vector<cv::Point2d> labels) { return is_contradicted(answer, rig, labels); };
  EXPECT_FALSE(contradicted({{320 + 28, 240}}));
  EXPECT_TRUE(contradicted({{320 + 29, 240}}));
  EXPECT_FALSE(contradicted({{320, 240 - 19}}));
  EXPECT_TRUE(contradicted({{320, 240 - 21}}));
  EXPECT_FALSE(contradicted({{320, 240 - 21}, {318, 241}})) << "one of those that look alike is enough";
  // Beside the axis, an error of the distance moves the image point along the line through the principal point: 1 m by
  // 500 px * 0.2.
  answer.position << 2, 2 - 0.2, 3;
  EXPECT_FALSE(contradicted({{420 - 300, 240}}));
  EXPECT_TRUE(contradicted({{420, 240 + 21}}));
}

}  // namespace
}  // namespace multireach::bench
