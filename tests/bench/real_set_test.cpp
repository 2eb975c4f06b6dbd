// Sets of real images with measured positions, and what is said of wrong ones.
#include "bench/real/real_set.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "runtime/config.hpp"
#include "tests/temporary_folder.hpp"

namespace multireach::bench {
namespace {

// Parallel cameras, 0.1 m apart: what is 1 m before the left one's centre is at its principal point, and 50 px to the
// left in the right image.
constexpr char kCameras[] =
    "cameras:\n"
    "  left: {width_px: 640, height_px: 480, fx_px: 500, fy_px: 500, cx_px: 320, cy_px: 240}\n"
    "  right: {width_px: 640, height_px: 480, fx_px: 500, fy_px: 500, cx_px: 320, cy_px: 240}\n"
    "  left_to_right: {translation_m: [-0.1, 0, 0]}\n"
    "  left_to_robot: {translation_m: [0, 0, 0]}\n";

using Files = std::map<std::string, std::string>;

Files good() {
  return {{"set.yaml", std::string("name: balls\nuse: test\nleft: l.png\nright: r.png\npositions: p.csv\n") + kCameras},
          {"p.csv",
           "left_x_px,left_y_px,right_x_px,right_y_px,x_m,y_m,z_m\n320,240,270,240,0,0,1\n420,240,370,240,0.2,0,1\n"}};
}

RealSet load(const Files& files, const cv::Size& size = {640, 480}) {
  const testing::TemporaryFolder folder;
  for (const auto& [name, text] : files) std::ofstream(folder.path() + "/" + name) << text;
  for (const char* name : {"/l.png", "/r.png"}) cv::imwrite(folder.path() + name, cv::Mat(size, CV_8UC3, {9, 9, 9}));
  return RealSet::load(folder.path());
}

std::string refusal(const std::function<void(Files&)>& change, const cv::Size& size = {640, 480}) {
  Files files = good();
  change(files);
  try {
    load(files, size);
  } catch (const InputError& fault) {
    return fault.what();
  }
  return "none";
}

void replace(std::string& text, const std::string& part, const std::string& by) {
  const size_t at = text.find(part);
  ASSERT_NE(at, std::string::npos) << part;
  text.replace(at, part.size(), by);
}

TEST(RealSet, HasPositionsWithTheClicksOnThem) {
  const RealSet set = load(good());
  ASSERT_EQ(set.measured.size(), 2U);
  EXPECT_EQ(set.measured[1].left_px, cv::Point2d(420, 240));
  EXPECT_EQ(set.measured[1].right_px, cv::Point2d(370, 240));
  EXPECT_EQ(set.measured[1].p_W, Eigen::Vector3d(0.2, 0, 1));
  EXPECT_EQ(set.radius_m, 0);
  EXPECT_EQ(set.learn_left.size(), cv::Size(640, 480)) << "the pair itself, unless other pictures are named";
}

TEST(RealSet, SaysWhatIsWrongWithPositions) {
  const auto with = [](const std::string& part, const std::string& by) {
    return refusal([&](Files& files) { replace(files["p.csv"], part, by); });
  };
  const auto says = [](const std::string& fault, const std::string& part) {
    EXPECT_NE(fault.find(part), std::string::npos) << fault;
  };
  says(with("left_x_px,left_y_px", "left_y_px,left_x_px"), "p.csv, line 1: expected left_x_px,left_y_px");
  says(with("420,240,370", "420,240"), "p.csv, line 3: '420,240,240,0.2,0,1' is not left_x_px");
  says(with("0,0,1\n", "0,0,1,5\n"), "p.csv, line 2: '320,240,270,240,0,0,1,5' is not left_x_px");
  says(with("420,240,370", "720,240,370"), "p.csv, line 3: '720,240,370,240,0.2,0,1' has a pixel outside its image");
  says(with("0.2,0,1", "0.2,1,1"), "p.csv, line 3: by `cameras`");
  says(with("0.2,0,1", "0.2,0,-1"), "p.csv, line 3: by `cameras`");
}

TEST(RealSet, SaysWhatIsWrongWithTheRest) {
  const auto without = [](const std::string& line) {
    return refusal([&](Files& files) { replace(files["set.yaml"], line, ""); });
  };
  EXPECT_NE(without("  left_to_robot: {translation_m: [0, 0, 0]}\n").find("left_to_robot"), std::string::npos);
  EXPECT_NE(without("positions: p.csv\n").find("expected one of the keys images"), std::string::npos);
  const std::string small = refusal([](Files&) {}, {320, 240});
  EXPECT_NE(small.find("an image of the calibration's size, 640 x 480 pixels"), std::string::npos) << small;
  const std::string half = refusal([](Files& files) { files["set.yaml"] += "learn_left: l.png\n"; });
  EXPECT_NE(half.find("both learn_left and learn_right"), std::string::npos) << half;
}

}  // namespace
}  // namespace multireach::bench
