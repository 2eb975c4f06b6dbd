// What the OpenCV baseline could reach with limits of a contour's area.
#include "bench/real/limited_baseline.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace multireach::bench {
namespace {

constexpr int kImages = 100, kTooLarge = 400, kTooSmall = 30, kObject = 100;  // areas, px
const cv::Point2d kAt(50, 50), kElsewhere(200, 50);

/// In each image the object, something larger and something smaller.
LimitedBaseline cluttered() {
  LimitedBaseline limited;
  for (int k = 0; k < kImages; ++k)
    limited.add({{kElsewhere, kTooLarge}, {kAt, kObject}, {kElsewhere, kTooSmall}}, {kAt}, 1);
  return limited;
}

TEST(LimitedBaseline, FindsLimitsBetweenTheObjectAndTheRest) {
  const Score score = cluttered().best(kFewWrong);
  EXPECT_EQ(score.labelled, kImages);
  EXPECT_EQ(score.right, kImages);
  EXPECT_EQ(score.wrong, 0);
}

TEST(LimitedBaseline, GivesUpRightAnswersWhereTheyCostWrongOnes) {
  for (const auto& [others, right] : {std::pair(1, kImages + 1), std::pair(3, 0)}) {
    LimitedBaseline limited = cluttered();
    for (int k = 0; k < others; ++k) limited.add({{kElsewhere, kObject}}, {kAt}, 1);
    limited.add({{kAt, kObject}}, {kAt}, 1);
    EXPECT_EQ(limited.best(kFewWrong).right, right) << others << " of " << kImages + 1 + others;
  }
}

TEST(LimitedBaseline, FindsLimitsAmongMuchElse) {
  // Hundreds of other things, one of which is hardly larger than the object.
  LimitedBaseline limited;
  for (int k = 0; k < kImages; ++k) {
    std::vector<Baseline::Contour> contours{{kElsewhere, kObject + 2}, {kAt, kObject + 0.01 * k}};
    for (int small = 0; small < 200; ++small) contours.push_back({kElsewhere, 50 - 0.1 * small});
    limited.add(contours, {kAt}, 1);
  }
  EXPECT_EQ(limited.best(kFewWrong).right, kImages);
}

TEST(LimitedBaseline, AnswersNothingWhereNothingIs) {
  LimitedBaseline limited;
  limited.add({}, {kAt}, 1);
  EXPECT_EQ(limited.best(kFewWrong).labelled, 1);
  EXPECT_EQ(limited.best(kFewWrong).right, 0);
}

TEST(Baseline, FindsWhatHasTheClickedColour) {
  cv::Mat image(120, 160, CV_8UC3, cv::Scalar::all(90));
  cv::circle(image, {40, 60}, 15, {30, 30, 200}, cv::FILLED);
  cv::circle(image, {120, 60}, 20, {30, 30, 200}, cv::FILLED);
  cv::circle(image, {80, 20}, 15, {200, 30, 30}, cv::FILLED);
  const auto contours = Baseline(image, {40, 60}).contours(image);
  ASSERT_EQ(contours.size(), 2U);
  EXPECT_LT(cv::norm(contours[0].centre - cv::Point2d(120, 60)), 1) << "the larger first";
  EXPECT_LT(cv::norm(contours[1].centre - cv::Point2d(40, 60)), 1);
  EXPECT_EQ(largest(contours, 1).size(), 1U);
  EXPECT_EQ(largest(contours, 3).size(), 2U);
}

}  // namespace
}  // namespace multireach::bench
