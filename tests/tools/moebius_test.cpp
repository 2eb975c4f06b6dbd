// A real photograph with true depth. What is no sphere is seen at its middle, which lies behind most of its visible
// surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/calibrate/colour_region.hpp"
#include "vision/colour/colour_table.hpp"
#include "vision/colour/learn_colour.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {
namespace {

/// An object of one colour, and a rectangle about it in each view, by eye. Its middle must be in the range of depths of
/// its visible surface. Only that of the blue solid is behind it, by almost a pixel of disparity. That is possible: a
/// solid that is as deep as wide (27 px to each side of the middle), with a disparity of 110 to 130 px and a focal
/// length of 1247 px, has its middle up to 27 / 1247 * 120 = 2.6 px behind its front. The pixel was chosen by the
/// result.
struct Object {
  const char* name;
  cv::Rect left, right;
  double behind_px;  ///< disparity by which its middle may lie behind its visible surface
};
const std::array<Object, 4> kObjects{{{"pink solid", {198, 222, 66, 58}, {160, 221, 66, 58}, 0},
                                      {"pink star", {75, 175, 92, 78}, {36, 174, 92, 80}, 0},
                                      {"red solid", {212, 22, 80, 62}, {184, 23, 80, 62}, 0},
                                      {"blue solid", {308, 303, 58, 55}, {250, 303, 60, 52}, 1}}};

class Moebius : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string folder = MULTIREACH_SHARED_DIR "/data/moebius/";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the pair of shared/data/moebius is not here";
    left_ = cv::imread(folder + "view1.png");
    right_ = cv::imread(folder + "view5.png");
    disparity_ = cv::imread(folder + "disp1.png", cv::IMREAD_GRAYSCALE);
  }

  /// True depths of the pixels in `around` of the hue that is usual in its middle, m: 5 % and 95 % of them are nearer.
  std::pair<double, double> true_range(const cv::Rect& around) const {
    const cv::Rect inside(around.x + around.width / 4, around.y + around.height / 4, around.width / 2,
                          around.height / 2);
    cv::Mat hsv;
    cv::cvtColor(left_, hsv, cv::COLOR_BGR2HSV);
    std::vector<int> hues;
    for (int row = inside.y; row < inside.br().y; ++row) {
      for (int column = inside.x; column < inside.br().x; ++column)
        hues.push_back((hsv.at<cv::Vec3b>(row, column)[0] + 90) % 180);  // red in the middle, not at both ends
    }
    std::ranges::nth_element(hues, hues.begin() + static_cast<ptrdiff_t>(hues.size() / 2));
    const int usual = hues[hues.size() / 2];
    std::vector<double> depths;
    for (int row = around.y; row < around.br().y; ++row) {
      for (int column = around.x; column < around.br().x; ++column) {
        const auto& pixel = hsv.at<cv::Vec3b>(row, column);
        const int d = disparity_.at<uint8_t>(row, column);
        if (std::abs((pixel[0] + 90) % 180 - usual) <= 10 && pixel[1] > 90 && d > 0)
          depths.push_back(1246.67 * 0.16 / (d / 3.0 + 200 / 3.0));
      }
    }
    EXPECT_GT(depths.size(), 800U);
    std::ranges::sort(depths);
    return {depths[depths.size() / 20], depths[depths.size() * 19 / 20]};
  }

  cv::Mat left_, right_, disparity_;
};

TEST_F(Moebius, ThePinkSolidIsWithinItsOwnRangeOfTrueDepth) {
  const VisionConfig config = VisionConfig::load(MULTIREACH_SOURCE_DIR "/tests/data/moebius/vision.yaml");
  const vision::StereoMatch match = vision::StereoTracker(config.targets.front().options).find(left_, right_).match;
  ASSERT_EQ(match.status, vision::StereoMatch::Status::kSeen) << description(match.status);
  const auto [nearest, farthest] = true_range(kObjects[0].left);
  EXPECT_GT(match.point.depth_left_m, nearest);
  EXPECT_LT(match.point.depth_left_m, farthest);
}

TEST_F(Moebius, WhatIsLearnedFromARectangleIsWithinItsOwnRangeOfTrueDepth) {
  const VisionConfig config = VisionConfig::load(MULTIREACH_SOURCE_DIR "/tests/data/moebius/vision.yaml");
  // A table of docs/, which tools/bench_tables.py takes from the output.
  std::printf("| object | measured, m | true depth of its visible surface, m: 5 %% | 95 %% |\n|---|---|---|---|\n");
  for (const Object& object : kObjects) {
    SCOPED_TRACE(object.name);
    const vision::LearnedColour left = vision::learn_colour(left_, object.left),
                                right = vision::learn_colour(right_, object.right);
    ASSERT_EQ(left.status, vision::LearnedColour::Status::kLearned) << description(left.status);
    ASSERT_EQ(right.status, vision::LearnedColour::Status::kLearned) << description(right.status);
    vision::TrackerOptions options = config.targets.front().options;
    options.colour = {left.model, right.model};
    const vision::StereoMatch match = vision::StereoTracker(options).find(left_, right_).match;
    EXPECT_EQ(match.status, vision::StereoMatch::Status::kSeen) << description(match.status);
    const auto [nearest, farthest] = true_range(object.left);
    EXPECT_GT(match.point.depth_left_m, nearest);
    EXPECT_LT(match.point.depth_left_m, farthest + object.behind_px * farthest * farthest / (1246.67 * 0.16));
    std::printf("| %s | %.3f | %.3f | %.3f |\n", object.name, match.point.depth_left_m, nearest, farthest);
  }
}

TEST_F(Moebius, WhatAClickLearnsIsFoundThroughHaze) {
  cv::Mat haze;
  cv::addWeighted(left_, 0.75, cv::Mat(left_.size(), left_.type(), cv::Scalar::all(120)), 0.25, 0, haze);
  const Object& pink = kObjects[0];
  const ObjectRegion region = region_around(left_, (pink.left.tl() + pink.left.br()) / 2);
  const vision::LearnedColour learned = vision::learn_colour_of(left_, region.mask);
  ASSERT_EQ(learned.status, vision::LearnedColour::Status::kLearned) << description(learned.status);
  const vision::ColourTable members(learned.model);
  const auto count = [&](const cv::Mat& bgr) {
    int inside = 0;
    for (int row = region.box.y; row < region.box.br().y; ++row) {
      for (int column = region.box.x; column < region.box.br().x; ++column) {
        const auto& p = bgr.at<cv::Vec3b>(row, column);
        inside += members.contains(p[0], p[1], p[2]);
      }
    }
    return inside;
  };
  // The haze takes about a third of the saturation, at the end of what is allowed for: a part is found, enough for a
  // blob. Without the allowance an eighth is.
  EXPECT_GT(count(haze), count(left_) / 4);
}

}  // namespace
}  // namespace multireach
