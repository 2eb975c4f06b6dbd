#include "vision/colour/colour_background.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mask_blobs.hpp"

namespace multireach::vision {
namespace {

const cv::Size kImage(330, 250);  // the last cells of both directions extend beyond it
const cv::Rect kWhole({0, 0}, kImage);

std::vector<Blob> rectangles(const std::vector<cv::Rect>& all) {
  cv::Mat mask(kImage, CV_8U, cv::Scalar(0));
  for (const cv::Rect& each : all) mask(each).setTo(255);
  return blobs_of(mask, 1);
}

double share(const ColourBackground& background, const cv::Rect& at) {
  return background.share_of(rectangles({at}).front());
}

TEST(ColourBackground, FillsWhereTheColourStaysAndNotWhereItPasses) {
  ColourBackground background(kImage);
  const cv::Rect still(40, 60, 50, 30), corner(300, 220, 30, 30);
  EXPECT_EQ(share(background, still), 0);
  for (int k = 0; k < 40; ++k) {
    const cv::Rect moving(5 + 6 * k, 150, 24, 24);
    background.learn(kWhole, rectangles({still, corner, moving}), {}, 1);
    EXPECT_LT(share(background, {moving.x + 6, 150, 24, 24}), 0.35) << k;
  }
  EXPECT_GT(share(background, still), 0.85);
  EXPECT_GT(share(background, corner), 0.85) << "cells at the border count too";
  EXPECT_LT(share(background, {40, 120, 50, 30}), 0.01);
  for (int k = 0; k < 40; ++k) background.learn(kWhole, rectangles({corner}), {}, 1);
  EXPECT_LT(share(background, still), 0.15) << "what was taken away is forgotten";
}

TEST(ColourBackground, OneLookMayStandForSeveralPairs) {
  ColourBackground often(kImage), seldom(kImage);
  const cv::Rect still(48, 64, 64, 48);
  for (int k = 0; k < 24; ++k) often.learn(kWhole, rectangles({still}), {}, 1);
  for (int k = 0; k < 3; ++k) seldom.learn(kWhole, rectangles({still}), {}, 8);
  EXPECT_NEAR(share(often, still), share(seldom, still), 0.1);
}

TEST(ColourBackground, LeavesTheObjectAndWhatIsOutsideOfTheWindow) {
  ColourBackground background(kImage);
  const cv::Rect object(100, 100, 40, 40), outside(250, 30, 40, 40);
  for (int k = 0; k < 50; ++k) background.learn({0, 0, 200, 200}, rectangles({object, outside}), {90, 90, 60, 60}, 1);
  EXPECT_EQ(share(background, object), 0);
  EXPECT_EQ(share(background, outside), 0);
}

TEST(ColourBackground, GoesOnFromItsState) {
  ColourBackground background(kImage);
  background.learn(kWhole, rectangles({{40, 60, 50, 30}, {200, 100, 80, 80}}), {}, 5);
  std::vector<double> state;
  background.serialize(state);
  ASSERT_EQ(state.size(), background.serialized_size());
  ColourBackground other(kImage);
  ASSERT_TRUE(other.valid(state));
  other.deserialize(state);
  for (auto* each : {&background, &other}) each->learn(kWhole, rectangles({{210, 110, 60, 60}}), {}, 2);
  std::vector<double> first, second;
  background.serialize(first);
  other.serialize(second);
  EXPECT_EQ(first, second);
  for (const double wrong : {-1.0, 0.5, 1e15, static_cast<double>(NAN)}) {
    std::vector<double> damaged = state;
    damaged[3] = wrong;
    EXPECT_FALSE(other.valid(damaged)) << wrong;
  }
  state.pop_back();
  EXPECT_FALSE(other.valid(state));
}

}  // namespace
}  // namespace multireach::vision
