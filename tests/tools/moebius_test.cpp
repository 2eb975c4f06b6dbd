// A real photograph with true depth.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "runtime/nodes/vision_node.hpp"

namespace multireach {
namespace {

TEST(Moebius, ThePinkSolidIsWithinItsOwnRangeOfTrueDepth) {
  const std::string folder = MULTIREACH_SHARED_DIR "/data/moebius/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the pair of shared/data/moebius is not here";
  const VisionConfig config = VisionConfig::load(MULTIREACH_SOURCE_DIR "/tests/data/moebius/vision.yaml");
  const cv::Mat left = cv::imread(folder + "view1.png"), right = cv::imread(folder + "view5.png");
  const cv::Mat disparity = cv::imread(folder + "disp1.png", cv::IMREAD_GRAYSCALE);
  const vision::Sighting sighting = vision::StereoTracker(config.targets.front().options).find(left, right);
  ASSERT_EQ(sighting.status, vision::Sighting::Status::kSeen) << description(sighting.status);

  // The solid's pixels, told by a rectangle around it and its strong pink, and their true depths.
  std::vector<double> depths;
  for (int row = 215; row < 285; ++row) {
    for (int column = 190; column < 270; ++column) {
      const auto& bgr = left.at<cv::Vec3b>(row, column);
      if (bgr[2] - bgr[1] < 0.25 * (bgr[2] + 2 * bgr[1] + bgr[0])) continue;
      if (const int d = disparity.at<uint8_t>(row, column)) depths.push_back(1246.67 * 0.16 / (d / 3.0 + 200 / 3.0));
    }
  }
  ASSERT_GT(depths.size(), 2000U);
  std::ranges::sort(depths);
  EXPECT_GT(sighting.point.depth_left_m, depths[depths.size() / 20]);
  EXPECT_LT(sighting.point.depth_left_m, depths[depths.size() * 19 / 20]);
}

}  // namespace
}  // namespace multireach
