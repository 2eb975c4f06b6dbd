// Regions that clicks propose, on generated pictures of shaded balls.
#include "tools/calibrate/colour_region.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/tools/shaded_balls.hpp"

namespace multireach {
namespace {

/// Share of the union of a region and a ball's disc that both have.
double overlap(const ObjectRegion& region, const Ball& ball) {
  cv::Mat disc = cv::Mat::zeros(region.mask.size(), CV_8UC1);
  cv::circle(disc, ball.centre, static_cast<int>(ball.radius), cv::Scalar::all(255), cv::FILLED);
  return static_cast<double>(cv::countNonZero(disc & region.mask)) / cv::countNonZero(disc | region.mask);
}

TEST(ObjectRegion, ReachesFromTheDarkSideToTheHighlight) {
  for (const Rgb& colour : {kRed, kOrange, kYellow, Rgb{40, 90, 180}}) {
    const Ball ball{{150, 110}, 22, colour};
    const cv::Mat image = picture({ball}, {}, 1);
    EXPECT_GT(overlap(region_around(image, ball.centre + cv::Point(4, 3)), ball), 0.8) << colour.r;
  }
}

TEST(ObjectRegion, DoesNotDriftToTheColourOfItsSurroundings) {
  // A door of nearly the ball's hue, with a border of much contrast to the white wall around it.
  for (const double radius : {10.0, 14.0, 20.0}) {
    const Ball ball{{150, 110}, radius, kYellow};
    const cv::Mat image = picture({ball}, {{{0, 0, kWidth, kHeight}, {235, 238, 236}}, {{110, 10, 80, 220}, kWood}}, 1);
    EXPECT_GT(overlap(region_around(image, ball.centre), ball), 0.8) << radius;
  }
}

TEST(ObjectRegion, OfAFrameIsNotWhatItEncloses) {
  const cv::Rect frame(120, 80, 72, 72), inside(138, 98, 36, 36);
  const cv::Mat image = picture({}, {{frame, {75, 95, 165}}, {inside, kRed}}, 3);
  const ObjectRegion region = region_around(image, cv::Point(129, 116));
  const double share = cv::countNonZero(region.mask(frame)) / static_cast<double>(frame.area() - inside.area());
  EXPECT_GT(share, 0.7);
  EXPECT_LT(cv::countNonZero(region.mask(inside)), 0.2 * inside.area());
}

TEST(ObjectRegion, HasThePanelsBeyondDarkSeams) {
  for (const Rgb& colour : {kRed, kOrange, Rgb{40, 90, 180}}) {
    for (const cv::Point& click : {cv::Point(150, 85), cv::Point(150, 130), cv::Point(118, 95), cv::Point(185, 125)}) {
      const Ball ball{{150, 110}, 50, colour, 0.08};
      const cv::Mat image = picture({ball}, {{{0, 165, kWidth, 75}, kWood}}, 5);
      const ObjectRegion region = region_around(image, click);
      EXPECT_GT(overlap(region, ball), 0.75) << colour.r << " at " << click.x << ',' << click.y;
      if (click.y > 100) continue;  // GrabCut finds the whole ball from there, whose holes belong to it
      EXPECT_LT(cv::countNonZero(region.mask.row(ball.centre.y)), 0.2 * 2 * ball.radius) << "seams are not learned";
    }
  }
}

TEST(ObjectRegion, OfAFrameIsNotAPrintedThingThatItEncloses) {
  const cv::Rect frame(90, 50, 140, 140), inside(112, 72, 96, 96);
  std::vector<Patch> patches{{frame, kOrange}, {inside, {40, 90, 180}}};
  for (int k = 0; k < 6; ++k) patches.push_back({{120, 80 + 15 * k, 80, 4}, {20, 20, 22}});
  const ObjectRegion region = region_around(picture({}, patches, 7), cv::Point(101, 120));
  EXPECT_LT(cv::countNonZero(region.mask(inside)), 0.2 * inside.area());
}

TEST(ObjectRegion, HasNoOtherObjectBeyondADarkGap) {
  const Ball ball{{110, 110}, 30, kOrange}, other{{174, 112}, 30, kOrange};
  const cv::Mat image = picture({ball, other}, {{{0, 0, kWidth, kHeight}, {40, 38, 36}}}, 6);
  EXPECT_GT(overlap(region_around(image, ball.centre), ball), 0.8);
}

TEST(ObjectRegion, IsNotTheBackgroundThatReachesTheBorder) {
  const auto share = [](const cv::Mat& image, const cv::Point& click) {
    return cv::countNonZero(region_around(image, click).mask) / static_cast<double>(image.total());
  };
  const Rgb blind{190, 195, 205};
  const cv::Rect at_border(0, 20, kWidth / 4, kHeight - 60), inside(40, 20, kWidth / 4, kHeight - 60);
  EXPECT_LT(share(picture({}, {{at_border, blind}}, 1), {30, 100}), 0.1);
  EXPECT_GT(share(picture({}, {{inside, blind}}, 1), {70, 100}), 0.15) << "a large thing of which all is in view";
  const Ball ball{{8, 110}, 20, kRed};
  EXPECT_GT(overlap(region_around(picture({ball}, {}, 1), {12, 110}), ball), 0.7) << "a ball that the border cuts off";
}

}  // namespace
}  // namespace multireach
