// Which blobs are parts of one object: drawn balls with seams, and objects that only stand beside each other.
#include "vision/colour/join_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/vision/mask_blobs.hpp"

namespace multireach::vision {
namespace {

const cv::Point kCentre(200, 180);

cv::Mat1b ball(int radius) {
  cv::Mat1b mask(400, 400, uint8_t{0});
  cv::circle(mask, kCentre, radius, 255, cv::FILLED);
  return mask;
}

/// A dark line through the ball, at an angle and a distance from its centre.
void seam(cv::Mat1b& mask, double degrees, double apart, int width) {
  const double angle = degrees * M_PI / 180;
  const cv::Point2d along(std::cos(angle), std::sin(angle)), across(-along.y, along.x);
  const cv::Point2d middle = cv::Point2d(kCentre) + apart * across;
  cv::line(mask, middle - 400 * along, middle + 400 * along, 0, width);
}

std::vector<Blob> joined(const cv::Mat1b& mask) {
  const std::vector<Blob> blobs = blobs_of(mask, 30);
  return join_parts(blobs);
}

double mean_x(const Blob& blob) {
  double sum = 0;
  for (const vision::Run& run : blob.runs) sum += 0.5 * (run.end - run.begin) * (run.begin + run.end - 1);
  return sum / blob.area;
}

TEST(JoinParts, ABallThatSeamsDivideIsOneObject) {
  for (const int radius : {40, 100, 160}) {
    for (int degrees = 0; degrees < 180; degrees += 15) {
      cv::Mat1b mask = ball(radius);
      const int width = static_cast<int>(0.06 * radius);  // 7 of 240 mm, as of many basketballs
      seam(mask, degrees, 0, width);
      seam(mask, degrees + 90, 0.3 * radius, width);
      seam(mask, degrees + 20, -0.5 * radius, width);
      ASSERT_GE(blobs_of(mask, 30).size(), 5U);
      const std::vector<Blob> joined_blobs = joined(mask);
      // A corner that a seam cuts off may be left.
      const Blob& whole = joined_blobs.at(0);
      EXPECT_GT(whole.area, 0.97 * cv::countNonZero(mask)) << "radius " << radius << ", turned by " << degrees;
      EXPECT_GT(whole.alternative_area, 0.2 * whole.area) << "each part may be it";
      EXPECT_LT(whole.alternative_area, whole.area);
      EXPECT_LT((whole.centroid - Eigen::Vector2d(kCentre.x, kCentre.y)).norm(), 0.05 * radius);
      EXPECT_NEAR(whole.centroid.x(), mean_x(whole), 1e-9);
      cv::Mat1b drawn(mask.size(), uint8_t{0});
      for (const vision::Run& run : whole.runs) drawn.row(run.row).colRange(run.begin, run.end) = 255;
      EXPECT_EQ(cv::countNonZero(drawn), whole.area);
      EXPECT_EQ(whole.box, cv::boundingRect(drawn));
      const cv::Moments moments = cv::moments(drawn, true);
      EXPECT_NEAR(whole.spread(0, 1), moments.mu11 / moments.m00, 1e-6);
      EXPECT_NEAR(whole.spread(1, 1), moments.mu02 / moments.m00, 1e-6);
      const auto row_and_column = [](const vision::Run& run) { return std::pair(run.row, run.begin); };
      EXPECT_TRUE(std::ranges::is_sorted(whole.runs, {}, row_and_column));
    }
  }
}

TEST(JoinParts, BallsBesideEachOtherAreNotOne) {
  for (const int radius : {8, 20, 50}) {
    for (const int gap : {1, 2, 3}) {
      for (int count = 2; count <= 4; ++count) {
        cv::Mat1b mask(400, 400, uint8_t{0});
        const int apart = 2 * radius + 1 + gap;
        // Two beside each other, three as a triangle, four as a square.
        const std::vector<cv::Point> centres{
            {100, 100},
            {100 + apart, 100},
            {count == 3 ? 100 + apart / 2 : 100, 100 + (count == 3 ? apart * 87 / 100 + 1 : apart)},
            {100 + apart, 100 + apart}};
        for (int k = 0; k < count; ++k) cv::circle(mask, centres[static_cast<size_t>(k)], radius, 255, cv::FILLED);
        ASSERT_EQ(blobs_of(mask, 30).size(), static_cast<size_t>(count));
        const std::vector<Blob> joined_blobs = joined(mask);
        EXPECT_EQ(joined_blobs.size(), static_cast<size_t>(count)) << "radius " << radius << ", gap " << gap;
      }
    }
  }
}

TEST(JoinParts, ABallAndAHandThatHoldsItAreNotOne) {
  cv::Mat1b mask = ball(60);
  cv::ellipse(mask, kCentre + cv::Point(0, 90), {70, 26}, 0, 0, 360, 255, cv::FILLED);
  cv::Mat1b around(mask.size(), uint8_t{0});
  cv::circle(around, kCentre, 61, 255, 4);  // the shadow between them
  mask.setTo(0, around);
  ASSERT_EQ(blobs_of(mask, 30).size(), 2U);
  EXPECT_EQ(joined(mask).size(), 2U);
}

// A ring that a seam divides is not compact: each half of it may be a part.
TEST(JoinParts, PartsThatMakeNoCompactObjectTellWhatTheyMayBePartsOf) {
  cv::Mat1b mask = ball(100);
  cv::circle(mask, kCentre, 60, 0, cv::FILLED);
  seam(mask, 90, 0, 8);
  const std::vector<Blob> parts = blobs_of(mask, 30), joined_blobs = joined(mask);
  ASSERT_EQ(parts.size(), 2U);
  ASSERT_EQ(joined_blobs.size(), 2U);
  const Eigen::Vector2d middle =
      (parts[0].area * parts[0].centroid + parts[1].area * parts[1].centroid) / (parts[0].area + parts[1].area);
  for (size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(joined_blobs[k].runs, parts[k].runs);
    EXPECT_EQ(joined_blobs[k].alternative_area, parts[0].area + parts[1].area);
    const Eigen::Vector2d apart = middle - joined_blobs[k].centroid;
    EXPECT_LT((joined_blobs[k].alternative_spread - apart * apart.transpose()).norm(), 1e-9);
  }
}

// A hand covers all of a ball but two panels. One is more compact than both together, and is left alone: each of them
// may still be a part of a larger object.
TEST(JoinParts, APartThatIsLeftOutMayBeAPartToo) {
  cv::Mat1b mask(400, 400, uint8_t{0});
  cv::ellipse(mask, {150, 180}, {45, 56}, 0, 0, 360, 255, cv::FILLED);
  cv::rectangle(mask, cv::Rect(130, 108, 41, 13), 255, cv::FILLED);
  const std::vector<Blob> parts = blobs_of(mask, 30);
  ASSERT_EQ(parts.size(), 2U);
  ASSERT_LT(compactness(parts[0]), 0.85);
  const std::vector<Blob> both = join_parts(parts);
  ASSERT_EQ(both.size(), 2U);
  for (const Blob& blob : both) EXPECT_EQ(blob.alternative_area, parts[0].area + parts[1].area) << blob.area;
}

// The middle one of three blobs in a row is a ball; what is left on both sides of it is not adjacent.
TEST(JoinParts, WhatIsLeftOnBothSidesOfAnObjectIsNotOne) {
  cv::Mat1b mask = ball(60);
  for (const int side : {-1, 1})
    cv::ellipse(mask, kCentre + cv::Point(side * 80, 0), {25, 70}, 0, 0, 360, 255, cv::FILLED);
  cv::Mat1b gap(mask.size(), uint8_t{0});
  cv::circle(gap, kCentre, 60, 255, 5);
  mask.setTo(0, gap);
  const std::vector<Blob> parts = blobs_of(mask, 30), objects = join_parts(parts);
  ASSERT_EQ(objects.size(), parts.size());
  for (const Blob& blob : objects) EXPECT_EQ(blob.alternative_area, 0) << blob.area;
}

// A frame around a bar: each row across the bar has two gaps, one of a seam's width and a wider one.
TEST(JoinParts, AMirroredImageHasTheSameParts) {
  for (const int left : {2, 9}) {
    cv::Mat1b mask(400, 400, uint8_t{0});
    cv::rectangle(mask, cv::Rect(100, 100, 120, 120), 255, cv::FILLED);
    cv::rectangle(mask, cv::Rect(130, 110, 60, 100), 0, cv::FILLED);
    cv::rectangle(mask, cv::Rect(130 + left, 132, 49, 56), 255, cv::FILLED);
    cv::Mat1b mirrored;
    cv::flip(mask, mirrored, 1);
    const std::vector<Blob> blobs = joined(mask), others = joined(mirrored);
    ASSERT_EQ(blobs.size(), others.size());
    for (size_t k = 0; k < blobs.size(); ++k) {
      EXPECT_EQ(blobs[k].area, others[k].area);
      EXPECT_EQ(blobs[k].alternative_area, others[k].alternative_area);
      EXPECT_GT(blobs[k].alternative_area, blobs[k].area) << "the bar is beside the frame";
    }
  }
}

// Of boxes that stand side by side, each may be the object: of one with the share w of the area, what is from the
// middle to it is at most sqrt((1 - w) / w) standard deviations of the parts' centroids.
TEST(JoinParts, EachPartOfAUnionMayBeTheObject) {
  for (const int higher : {0, 1, 8}) {
    cv::Mat1b mask(400, 400, uint8_t{0});
    cv::rectangle(mask, cv::Rect(150, 147 - 33 - higher, 90, 30), 255, cv::FILLED);
    cv::rectangle(mask, cv::Rect(150, 147 - higher, 90, 30 + higher), 255, cv::FILLED);
    cv::rectangle(mask, cv::Rect(150, 180, 90, 30), 255, cv::FILLED);
    const std::vector<Blob> parts = blobs_of(mask, 30), objects = join_parts(parts);
    ASSERT_EQ(parts.size(), 3U);
    ASSERT_EQ(objects.size(), 1U);
    for (const Blob& part : parts) {
      const double share = part.area / objects[0].area, apart = part.centroid.y() - objects[0].centroid.y();
      EXPECT_LE(apart * apart, (1 - share) / share * objects[0].alternative_spread(1, 1)) << higher;
    }
  }
}

// A bar cuts a box in two, of which one is compact itself.
TEST(JoinParts, ACompactPartOfACompactObjectMayBeAPart) {
  cv::Mat1b mask(400, 400, uint8_t{0});
  cv::rectangle(mask, cv::Rect(150, 100, 72, 36), 255, cv::FILLED);
  cv::rectangle(mask, cv::Rect(150, 139, 72, 69), 255, cv::FILLED);
  const std::vector<Blob> parts = blobs_of(mask, 30), objects = join_parts(parts);
  ASSERT_EQ(parts.size(), 2U);
  ASSERT_GT(compactness(parts[0]), 0.9);
  ASSERT_EQ(objects.size(), 2U) << "or this test shows nothing";
  EXPECT_EQ(objects[0].alternative_area, parts[0].area + parts[1].area);
}

TEST(JoinParts, OneBlobAndNoneStayWhatTheyAre) {
  EXPECT_TRUE(join_parts({}).empty());
  const std::vector<Blob> one = joined(ball(50));
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(one[0].alternative_area, 0);
}

}  // namespace
}  // namespace multireach::vision
