// What ragged blobs grow to: drawn parts of things, and the things that wider colours show.
#include "vision/colour/grow_blobs.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tests/vision/mask_blobs.hpp"

namespace multireach::vision {
namespace {

const cv::Point kCentre(200, 180);
constexpr int kRadius = 60;
const cv::Rect kWindow(0, 0, 400, 400);

cv::Mat1b ball() {
  cv::Mat1b mask(kWindow.size(), uint8_t{0});
  cv::circle(mask, kCentre, kRadius, 255, cv::FILLED);
  return mask;
}

/// The ball without what is beside a band of a half height, in radii, below its centre.
cv::Mat1b band(double half_height) {
  cv::Mat1b mask = ball();
  const int middle = kCentre.y + kRadius / 3, half = static_cast<int>(half_height * kRadius);
  mask.rowRange(0, middle - half) = 0;
  mask.rowRange(middle + half, mask.rows) = 0;
  return mask;
}

const Blob* grown(const cv::Mat1b& part, const cv::Mat1b& of_wider_colours, const cv::Rect& window = kWindow) {
  static std::vector<Blob> wider;
  const Blob ragged = blobs_of(part, 30).at(0);
  const cv::Rect searched = surroundings_of(ragged) & window;
  cv::Mat1b seen(of_wider_colours.size(), uint8_t{0});
  of_wider_colours(searched).copyTo(seen(searched));
  wider = blobs_of(seen, 30);
  return is_ragged(ragged) ? whole_of(ragged, wider, searched, window) : nullptr;
}

TEST(GrowBlobs, ABandOfABallGrowsToTheBall) {
  for (const double half_height : {0.2, 0.25, 0.3}) {
    const Blob* whole = grown(band(half_height), ball());
    ASSERT_NE(whole, nullptr) << half_height;
    EXPECT_EQ(whole->area, cv::countNonZero(ball()));
    EXPECT_LT((whole->centroid - Eigen::Vector2d(kCentre.x, kCentre.y)).norm(), 0.01 * kRadius);
  }
}

TEST(GrowBlobs, ACompactBlobIsNotRagged) {
  EXPECT_FALSE(is_ragged(blobs_of(ball(), 30).at(0)));
  EXPECT_EQ(grown(ball(), ball()), nullptr);
}

TEST(GrowBlobs, NothingGrowsToWhatIsMuchLargerRaggedOrElsewhere) {
  EXPECT_EQ(grown(band(0.1), ball()), nullptr) << "more than five times as large";
  cv::Mat1b with_arm = ball();
  cv::rectangle(with_arm, {kCentre.x, kCentre.y - 20, 190, 40}, 255, cv::FILLED);
  EXPECT_EQ(grown(band(0.25), with_arm), nullptr) << "a ball with an arm is ragged";
  cv::Mat1b lower_half = ball();
  lower_half.rowRange(0, kCentre.y + kRadius / 3) = 0;
  EXPECT_EQ(grown(band(0.25), lower_half), nullptr) << "contains just half of it";
}

TEST(GrowBlobs, NothingGrowsToWhatReachesBeyondTheSearchedPart) {
  // A ragged ring, and the disc that fills it, in a part of the image that ends at the middle of the disc.
  cv::Mat1b ring(kWindow.size(), uint8_t{0}), half = ring.clone();
  cv::circle(ring, kCentre, kRadius, 255, 20);
  cv::circle(half, kCentre, kRadius + 10, 255, cv::FILLED);
  cv::Rect searched = kWindow;
  searched.width = kCentre.x + kRadius;
  half.colRange(searched.width, half.cols) = 0;
  ring.colRange(searched.width, ring.cols) = 0;
  const Blob ragged = blobs_of(ring, 30).at(0);
  const std::vector<Blob> wider = blobs_of(half, 30);
  ASSERT_TRUE(is_ragged(ragged));
  EXPECT_EQ(whole_of(ragged, wider, searched, kWindow), nullptr);
  EXPECT_EQ(whole_of(ragged, wider, searched, searched), &wider[0]) << "nothing is searched beyond the window";
}

}  // namespace
}  // namespace multireach::vision
