// What blobs of low compactness grow to: drawn parts of things, and the things that wider colours show.
#include "vision/colour/grow_blobs.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <vector>

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

/// A band of the ball, `half_height` radii up and down from a third of the radius below the centre.
cv::Mat1b band(double half_height) {
  cv::Mat1b mask = ball();
  const int middle = kCentre.y + kRadius / 3, half = static_cast<int>(half_height * kRadius);
  mask.rowRange(0, middle - half) = 0;
  mask.rowRange(middle + half, mask.rows) = 0;
  return mask;
}

struct Grown {
  Blob seed;
  std::vector<Blob> wider;
  GrownBlob grown;
};

/// What the part grows to where wider colours show `of_wider_colours`.
Grown grown(const cv::Mat1b& part, const cv::Mat1b& of_wider_colours) {
  Grown result{.seed = blobs_of(part, 30).at(0), .wider = {}, .grown = {}};
  const cv::Rect searched = surroundings_of(result.seed) & kWindow;
  cv::Mat1b seen(of_wider_colours.size(), uint8_t{0});
  of_wider_colours(searched).copyTo(seen(searched));
  result.wider = blobs_of(seen, 30);
  result.grown = grown_blob(result.seed, result.wider, searched, kWindow);
  return result;
}

void expect_nothing(const cv::Mat1b& part, const cv::Mat1b& of_wider_colours, const char* why) {
  const Grown nothing = grown(part, of_wider_colours);
  EXPECT_EQ(nothing.grown.blob, nullptr) << why;
  EXPECT_FALSE(nothing.grown.cut_off) << why << ", not because the search ends there";
}

TEST(GrowBlobs, ABandOfABallGrowsToTheBall) {
  for (const double half_height : {0.2, 0.25, 0.3}) {
    const Grown whole = grown(band(half_height), ball());
    EXPECT_TRUE(has_low_compactness(whole.seed));
    ASSERT_NE(whole.grown.blob, nullptr) << half_height;
    EXPECT_EQ(whole.grown.blob->area, cv::countNonZero(ball()));
    EXPECT_LT((whole.grown.blob->centroid - Eigen::Vector2d(kCentre.x, kCentre.y)).norm(), 0.01 * kRadius);
  }
}

TEST(GrowBlobs, HalfADiscHasALowCompactnessThreeQuartersHaveNot) {
  EXPECT_FALSE(has_low_compactness(blobs_of(ball(), 30).at(0)));
  cv::Mat1b more = ball(), half = ball();
  more.rowRange(0, kCentre.y - kRadius / 2) = 0;
  half.rowRange(0, kCentre.y) = 0;
  EXPECT_FALSE(has_low_compactness(blobs_of(more, 30).at(0)));
  EXPECT_TRUE(has_low_compactness(blobs_of(half, 30).at(0)));
}

TEST(GrowBlobs, NothingGrowsToWhatIsMuchLarger) {
  expect_nothing(band(0.1), ball(), "a tenth of the ball");
}

TEST(GrowBlobs, NothingGrowsToWhatIsNotCompact) {
  cv::Mat1b with_arm = ball();
  cv::rectangle(with_arm, {kCentre.x, kCentre.y - 15, 2 * kRadius, 30}, 255, cv::FILLED);
  expect_nothing(band(0.25), with_arm, "a ball with an arm");
}

TEST(GrowBlobs, NothingGrowsToWhatIsHardlyMoreCompact) {
  // A little more than half of a disc has a low compactness. Three quarters of it are compact, but hardly more so.
  cv::Mat1b part = ball(), more = ball();
  part.rowRange(0, kCentre.y - 8) = 0;
  more.rowRange(0, kCentre.y - 26) = 0;
  const double before = compactness(blobs_of(part, 30).at(0)), after = compactness(blobs_of(more, 30).at(0));
  ASSERT_GE(after, 0.7);
  ASSERT_LT(after, 1.3 * before);
  expect_nothing(part, more, "hardly more compact");
}

TEST(GrowBlobs, NothingGrowsToWhatContainsHalfOfItOrLess) {
  cv::Mat1b beside(kWindow.size(), uint8_t{0});
  cv::circle(beside, kCentre + cv::Point(kRadius, kRadius / 3), kRadius - 2, 255, cv::FILLED);
  const Grown nothing = grown(band(0.25), beside);
  ASSERT_EQ(nothing.wider.size(), 1U);
  ASSERT_GT(common_pixels(nothing.wider[0], nothing.seed), nothing.seed.area / 3);
  expect_nothing(band(0.25), beside, "it contains less than half of the band");
}

TEST(GrowBlobs, NothingGrowsToWhatIsCutOffWhereTheSearchEnds) {
  // A ring, and the disc that fills it, where the search ends 10 px inside the disc's right edge.
  cv::Mat1b ring(kWindow.size(), uint8_t{0}), disc = ring.clone();
  cv::circle(ring, kCentre, kRadius, 255, 20);
  cv::circle(disc, kCentre, kRadius + 10, 255, cv::FILLED);
  cv::Rect searched = kWindow;
  searched.width = kCentre.x + kRadius;
  disc.colRange(searched.width, disc.cols) = 0;
  ring.colRange(searched.width, ring.cols) = 0;
  const Blob seed = blobs_of(ring, 30).at(0);
  const std::vector<Blob> wider = blobs_of(disc, 30);
  ASSERT_TRUE(has_low_compactness(seed));
  const GrownBlob cut_off = grown_blob(seed, wider, searched, kWindow);
  EXPECT_EQ(cut_off.blob, nullptr);
  EXPECT_TRUE(cut_off.cut_off);
  EXPECT_EQ(grown_blob(seed, wider, searched, searched).blob, &wider[0]) << "the image ends there";
}

}  // namespace
}  // namespace multireach::vision
