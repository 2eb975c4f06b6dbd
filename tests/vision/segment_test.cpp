#include "vision/segment.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "vision/colour_class.hpp"

namespace multireach::vision {
namespace {

TEST(ColourTable, TakesTheReferenceAtAnyExposureAndNothingElse) {
  const ColourTable table({.references = {{220, 40, 110}}});
  const auto contains = [&](double r, double g, double b) {
    return table.contains(static_cast<uint8_t>(b), static_cast<uint8_t>(g), static_cast<uint8_t>(r));
  };
  for (const double exposure : {0.4, 0.6, 0.8, 1.0, 1.1})
    EXPECT_TRUE(contains(220 * exposure, 40 * exposure, 110 * exposure)) << exposure;
  EXPECT_FALSE(contains(5, 1, 3)) << "too dark to tell";
  EXPECT_FALSE(contains(128, 128, 128));
  EXPECT_FALSE(contains(230, 140, 40)) << "orange";
  EXPECT_FALSE(contains(50, 110, 190)) << "blue";
  EXPECT_FALSE(contains(255, 255, 255));
}

cv::Mat mask_with_disc(double x, double y, double radius) {
  cv::Mat mask = cv::Mat::zeros(100, 120, CV_8UC1);
  for (int row = 0; row < mask.rows; ++row) {
    for (int column = 0; column < mask.cols; ++column) {
      if (std::hypot(column - x, row - y) < radius) mask.at<uint8_t>(row, column) = 255;
    }
  }
  return mask;
}

TEST(LargestBlob, CentroidAndAreaOfADisc) {
  // A centroid half a pixel off would show here: the disc's centre is where it is drawn.
  for (const auto& [x, y] : {std::pair(50.0, 40.0), {50.5, 40.5}, {61.3, 47.8}}) {
    const auto blob = largest_blob(mask_with_disc(x, y, 14), 30);
    ASSERT_TRUE(blob);
    EXPECT_NEAR(blob->centroid.x(), x, 0.1);
    EXPECT_NEAR(blob->centroid.y(), y, 0.1);
    EXPECT_NEAR(blob->area, M_PI * 14 * 14, 15);
    EXPECT_FALSE(blob->cut_off);
  }
}

TEST(LargestBlob, IgnoresSmallerBlobsSpecksAndHoles) {
  cv::Mat mask = mask_with_disc(60, 50, 15);
  mask |= mask_with_disc(20, 20, 8);
  mask.at<uint8_t>(90, 5) = 255;
  mask -= mask_with_disc(64, 54, 4);  // a highlight
  const auto blob = largest_blob(mask, 30);
  ASSERT_TRUE(blob);
  EXPECT_NEAR(blob->centroid.x(), 60, 0.1);
  EXPECT_NEAR(blob->centroid.y(), 50, 0.1);
}

TEST(LargestBlob, NothingWhereThereIsNothing) {
  EXPECT_FALSE(largest_blob(cv::Mat::zeros(100, 120, CV_8UC1), 30));
  EXPECT_FALSE(largest_blob(mask_with_disc(50, 50, 2), 30)) << "too small";
}

TEST(LargestBlob, KnowsThatItIsCutOff) {
  EXPECT_TRUE(largest_blob(mask_with_disc(5, 50, 10), 30)->cut_off);
  EXPECT_TRUE(largest_blob(mask_with_disc(60, 97, 10), 30)->cut_off);
  EXPECT_TRUE(largest_blob(cv::Mat(100, 120, CV_8UC1, cv::Scalar(255)), 30)->cut_off) << "all pixels in the class";
}

}  // namespace
}  // namespace multireach::vision
