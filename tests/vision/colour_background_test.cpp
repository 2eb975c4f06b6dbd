#include "vision/colour/colour_background.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mask_blobs.hpp"
#include "vision/packed_cells.hpp"

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
  const std::vector<cv::Rect> around{{90, 90, 60, 60}};
  for (int k = 0; k < 50; ++k) background.learn({0, 0, 200, 200}, rectangles({object, outside}), around, 1);
  EXPECT_EQ(share(background, object), 0);
  EXPECT_EQ(share(background, outside), 0);
}

TEST(ColourBackground, ForgetsWhereABlobIs) {
  ColourBackground background(kImage);
  const cv::Rect found(40, 60, 50, 30), elsewhere(200, 100, 40, 40);
  for (int k = 0; k < 40; ++k) background.learn(kWhole, rectangles({found, elsewhere}), {}, 1);
  background.forget(rectangles({found}).front());
  EXPECT_EQ(share(background, found), 0);
  EXPECT_GT(share(background, elsewhere), 0.85);
}

TEST(ColourBackground, GoesOnFromItsState) {
  ColourBackground background(kImage);
  background.learn(kWhole, rectangles({{40, 60, 50, 30}, {200, 100, 80, 80}}), {}, 5);
  std::vector<double> state;
  append_packed(background.cells(), state);
  ASSERT_EQ(state.size(), packed_size(background.cells().size()));
  ColourBackground other(kImage);
  ASSERT_TRUE(is_packed(state, other.cells().size()));
  unpack(state, other.cells());
  for (auto* each : {&background, &other}) each->learn(kWhole, rectangles({{210, 110, 60, 60}}), {}, 2);
  EXPECT_TRUE(std::ranges::equal(background.cells(), other.cells()));
}

TEST(PackedCells, ComeBackAndDamageIsNoticed) {
  for (const size_t count : {0U, 1U, 5U, 6U, 7U, 300U}) {
    std::vector<uint8_t> cells(count), again(count);
    for (size_t k = 0; k < count; ++k) cells[k] = static_cast<uint8_t>(255 - 37 * k);
    std::vector<double> state;
    append_packed(cells, state);
    ASSERT_TRUE(is_packed(state, count)) << count;
    unpack(state, again);
    EXPECT_EQ(cells, again);
    EXPECT_FALSE(is_packed(state, count + 6));
    for (const double wrong : {-1.0, 0.5, 1e15, static_cast<double>(NAN)}) {
      if (state.empty()) continue;
      std::vector<double> damaged = state;
      damaged.back() = wrong;
      EXPECT_FALSE(is_packed(damaged, count)) << wrong;
    }
  }
}

}  // namespace
}  // namespace multireach::vision
