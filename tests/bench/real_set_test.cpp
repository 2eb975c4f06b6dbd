// Sets of real images with measured positions, and what is said of wrong ones.
#include "bench/real/real_set.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>

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
  says(with("420,240,370", "720,240,370"), "p.csv, line 3: a pixel is outside its image");
  says(with("0.2,0,1", "0.2,1,1"), "p.csv, line 3: by `cameras`");
  says(with("0.2,0,1", "0.2,0,-1"), "p.csv, line 3: by `cameras`");
}

TEST(RealSet, SaysWhatIsWrongWithLabelsOfOneCamera) {
  const testing::TemporaryFolder folder;
  const auto file = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder.path() + "/" + name) << text;
  };
  cv::imwrite(folder.path() + "/1.png", cv::Mat(48, 64, CV_8UC3, {9, 9, 9}));
  file("set.yaml", "name: ball\nuse: test\nimages: .\nlabels: labels.csv\nframes_per_s: 30\ndisparity_px: 9\n");
  const auto load_labels = [&](const std::string& text) -> std::string {
    file("labels.csv", text);
    try {
      return std::to_string(RealSet::load(folder.path()).labelled.at(0).centres.size());
    } catch (const InputError& fault) {
      return fault.what();
    }
  };
  EXPECT_EQ(load_labels("image,object,x_px,y_px\n1.png,red,32,24\n"), "1");
  for (const auto& [text, part] : std::map<std::string, std::string>{
           {"1.png,red,32,24\n1.png,red,3,4\n", "labels.csv, line 1: expected image,object,x_px,y_px"},
           {"image,object,x_px,y_px\n1.png,red,32;24\n", "labels.csv, line 2: '1.png,red,32;24' is not image,object"},
           {"image,object,x_px,y_px\n1.png,red,32,24,5\n", "labels.csv, line 2"}}) {
    const std::string said = load_labels(text);
    EXPECT_NE(said.find(part), std::string::npos) << said;
  }
}

TEST(RealSet, OfOneCameraHasASecondImageThatShowsAllOfTheFirst) {
  const testing::TemporaryFolder folder;
  const auto file = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder.path() + "/" + name) << text;
  };
  cv::Mat image(48, 64, CV_8UC3);
  cv::randu(image, 0, 255);
  cv::imwrite(folder.path() + "/1.png", image);
  file("set.yaml", "name: ball\nuse: test\nimages: .\nlabels: labels.csv\nframes_per_s: 30\ndisparity_px: 9\n");
  file("labels.csv", "image,object,x_px,y_px\n1.png,red,32,24\n");
  const RealSet set = RealSet::load(folder.path());
  const cv::Mat second = second_image(image);
  EXPECT_EQ(second.size(), cv::Size(set.rig.right.width, set.rig.right.height));
  EXPECT_EQ(cv::norm(second.colRange(kAddedColumns, second.cols), image, cv::NORM_INF), 0);
  // A point at the depth f b / disparity has the same pixel in both images.
  const Eigen::Vector3d p_L(0.1, -0.05, 600 * 0.06 / 9);
  const Eigen::Vector2d left = set.rig.left.project(p_L), right = set.rig.right.project(set.rig.X_RL * p_L);
  EXPECT_NEAR((right - left - Eigen::Vector2d(kAddedColumns, 0)).norm(), 0, 1e-9);
}

TEST(RealSet, SaysWhatIsWrongWithTheRest) {
  const auto without = [](const std::string& line) {
    return refusal([&](Files& files) { replace(files["set.yaml"], line, ""); });
  };
  EXPECT_NE(without("  left_to_robot: {translation_m: [0, 0, 0]}\n").find("left_to_robot"), std::string::npos);
  EXPECT_NE(without("positions: p.csv\n").find("expected one of the keys images"), std::string::npos);
  const std::string small = refusal([](Files&) {}, {320, 240});
  EXPECT_NE(small.find("l.png: is of 320 x 240 pixels; expected 640 x 480"), std::string::npos) << small;
  const std::string half = refusal([](Files& files) { files["set.yaml"] += "learn_left: l.png\n"; });
  EXPECT_NE(half.find("both learn_left and learn_right"), std::string::npos) << half;
}

Files two_cameras() {
  return {{"set.yaml", std::string("name: square\nuse: tuning\nleft_images: left\nright_images: right\n") +
                           "labels: labels.csv\nclicks: clicks.csv\nframes_per_s: 15\n" + kCameras},
          {"labels.csv",
           "image,object,left_x_px,left_y_px,right_x_px,right_y_px\n1.png,red,320,240,270,240.5\n"
           "2.png,red,325,240,275,240\n9.png,red,1,1,1,1\n"},
          {"clicks.csv", "image,object,left_x_px,left_y_px,right_x_px,right_y_px\n2.png,red,326,250,276,250\n"}};
}

/// Loads a video of two cameras, or returns what is said against it.
std::optional<RealSet> load_two(const Files& files, std::string* fault = nullptr, const std::string& last = "2.png",
                                const cv::Size& size = {640, 480}) {
  const testing::TemporaryFolder folder;
  for (const auto& [name, text] : files) std::ofstream(folder.path() + "/" + name) << text;
  for (const std::string side : {"/left", "/right"}) {
    std::filesystem::create_directory(folder.path() + side);
    for (const std::string& name : {std::string("1.png"), side == "/left" ? "2.png" : last})
      cv::imwrite(folder.path() + side + "/" + name, cv::Mat(size, CV_8UC3, {9, 9, 9}));
  }
  try {
    return RealSet::load(folder.path());
  } catch (const InputError& error) {
    if (fault != nullptr) *fault = error.what();
    return std::nullopt;
  }
}

TEST(RealSet, HasTheLabelsOfAVideoOfTwoCameras) {
  const auto set = load_two(two_cameras());
  ASSERT_TRUE(set && set->stereo.size() == 1 && set->images.size() == 2 && set->right_images.size() == 2);
  const StereoObject& object = set->stereo[0];
  ASSERT_EQ(object.centres.size(), 2U) << "a label of an image that is not there does not count";
  EXPECT_EQ(object.centres.at(0).right, cv::Point2d(270, 240.5));
  ASSERT_EQ(object.clicks.size(), 1U);
  EXPECT_EQ(object.clicks.at(1).left, cv::Point2d(326, 250));
  Files on_labels = two_cameras();
  replace(on_labels["set.yaml"], "clicks: clicks.csv\n", "");
  const auto clicked_at_labels = load_two(on_labels);
  ASSERT_TRUE(clicked_at_labels);
  EXPECT_EQ(clicked_at_labels->stereo[0].clicks.size(), 2U);
}

TEST(RealSet, SaysWhatIsWrongWithAVideoOfTwoCameras) {
  const auto says = [](const std::string& file, const std::string& part, const std::string& by,
                       const std::string& expected) {
    Files files = two_cameras();
    replace(files[file], part, by);
    std::string fault;
    load_two(files, &fault);
    EXPECT_NE(fault.find(expected), std::string::npos) << fault;
  };
  says("labels.csv", "270,240.5", "270", "labels.csv, line 2: '1.png,red,320,240,270' is not image,object,left_x_px");
  says("labels.csv", "240.5", "240.5,7", "labels.csv, line 2");
  says("labels.csv", "image,object", "picture,object", "labels.csv, line 1: expected image,object,left_x_px");
  says("labels.csv", "2.png,red", "1.png,red", "labels.csv, line 3: a second point of 'red' in 1.png");
  says("clicks.csv", "2.png,red", "2.png,blue", "only objects that have labels, not 'blue'");
  says("labels.csv", "1.png,red", "1.png,blue", "a file with clicks on 'blue'");
  says("clicks.csv", "326,250", "726,250", "inside 2.png");
  says("set.yaml", "right_images: right", "right_images: rihgt", "right_images");
  std::string fault;
  load_two(two_cameras(), &fault, "3.png");
  EXPECT_NE(fault.find("images of the same names as left_images"), std::string::npos) << fault;
  load_two(two_cameras(), &fault, "2.png", {320, 240});
  EXPECT_NE(fault.find("is of 320 x 240 pixels; expected 640 x 480"), std::string::npos) << fault;
}

}  // namespace
}  // namespace multireach::bench
