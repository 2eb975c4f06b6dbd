#include "vision/node/vision_config.hpp"

#include <gtest/gtest.h>

#include "runtime/files.hpp"
#include "tests/input_fault.hpp"
#include "tests/temporary_folder.hpp"

namespace multireach {
namespace {

using testing::input_fault;

/// Two level cameras at W's origin, or cameras whose pose is not known, and a tracker with these keys.
std::string vision_text(const std::string& tracker, bool posed = true,
                        const std::string& colour = "{references: [{rgb: [220, 40, 110]}]}") {
  const std::string camera = "{width_px: 320, height_px: 240, fx_px: 300, fy_px: 300, cx_px: 160, cy_px: 120}";
  return "cameras:\n  left: " + camera + "\n  right: " + camera + "\n  left_to_right: {translation_m: [-0.1, 0, 0]}\n" +
         (posed ? "  left_to_robot: {translation_m: [0, 0, 0]}\n" : "") + "colour: " + colour +
         "\ntracker: " + tracker + "\n";
}

class VisionConfigTest : public ::testing::Test {
 protected:
  VisionConfig load(const std::string& text) {
    write_text_file(path_, text);
    return VisionConfig::load(path_);
  }
  std::string refusal(const std::string& text) {
    return input_fault([&] { load(text); });
  }

  testing::TemporaryFolder folder_;
  std::string path_ = folder_ / "vision.yaml";
};

TEST_F(VisionConfigTest, ASearchRegionIsABoxInMetres) {
  const VisionConfig config = load(vision_text("{search_region_m: {min: [-0.1, -0.2, 0.5], max: [0.1, 0.2, 1.5]}}"));
  const auto region = config.targets.front().options.search_region;
  ASSERT_TRUE(region);
  EXPECT_EQ(region->min(), Eigen::Vector3d(-0.1, -0.2, 0.5));
  EXPECT_EQ(region->max(), Eigen::Vector3d(0.1, 0.2, 1.5));
  EXPECT_FALSE(load(vision_text("{}")).targets.front().options.search_region);
}

TEST_F(VisionConfigTest, ASearchRegionThatCannotBeIsRefusedByName) {
  const auto region = [](const char* box) { return vision_text(std::string("{search_region_m: ") + box + "}"); };
  EXPECT_NE(refusal(region("{min: [0, 0, 1], max: [0.1, -0.1, 2]}")).find("tracker.search_region_m.max"),
            std::string::npos);
  EXPECT_NE(refusal(region("{min: [0, 0, 1]}")).find("search_region_m.max"), std::string::npos);
  EXPECT_NE(refusal(region("{min: [0, 0, 1], max: [1, 1, 2], unit: mm}")).find("unit"), std::string::npos);
  EXPECT_NE(refusal(region("{min: [0, 0, -2], max: [1, 1, -1]}")).find("the left camera does not see search_region_m"),
            std::string::npos);
  const std::string unposed = vision_text("{search_region_m: {min: [0, 0, 1], max: [1, 1, 2]}}", false);
  EXPECT_NE(refusal(unposed).find("needs cameras.left_to_robot"), std::string::npos);
}

// Red alone is (4, 0), and no variance of numbers from -2 to 4 exceeds 9.
TEST_F(VisionConfigTest, ColoursThatNoPixelHasAreRefusedByName) {
  const auto colours = [](const std::string& mean, const std::string& covariance) {
    const std::string model =
        "{tolerance: 3, min_luma: 10, max_luma: 250, noise_grey_levels: 2, object: [{mean: " + mean +
        ", covariance: " + covariance + "}]}";
    return vision_text("{}", true, "{left: " + model + ", right: " + model + "}");
  };
  EXPECT_NO_THROW(load(colours("[4, 0]", "[9, 0, 9]")));
  EXPECT_NE(refusal(colours("[1.0e200, 0]", "[0.1, 0, 0.1]")).find("mean' expected two numbers from -2 to 4"),
            std::string::npos);
  EXPECT_NE(refusal(colours("[0, -2.1]", "[0.1, 0, 0.1]")).find("mean"), std::string::npos);
  for (const char* covariance : {"[0, 0, 0.1]", "[0.1, 0.1, 0.1]", "[0.1, 0, 9.1]", "[1.0e200, 0, 1.0e200]"})
    EXPECT_NE(refusal(colours("[0, 0]", covariance)).find("covariance' expected three numbers"), std::string::npos)
        << covariance;
}

}  // namespace
}  // namespace multireach
