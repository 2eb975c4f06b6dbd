// A real video: a black cup that a hand turns and moves before a bright wall.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "tests/temporary_folder.hpp"
#include "vision/colour/find.hpp"
#include "vision/colour/learn_colour.hpp"
#include "vision/stereo_vision.hpp"

namespace multireach {
namespace {

constexpr const char* kVideo = "/usr/share/doc/opencv-doc/opencv4/html/cup.mp4.gz";

/// The cup in every 27th frame, by eye, to some pixels.
const std::array<cv::Rect, 9> kByEye{{{306, 124, 108, 258},
                                      {312, 120, 112, 268},
                                      {140, 136, 232, 276},
                                      {66, 136, 196, 278},
                                      {268, 80, 220, 262},
                                      {336, 134, 124, 220},
                                      {282, 142, 82, 206},
                                      {266, 122, 118, 282},
                                      {252, 80, 126, 320}}};

/// The share of the union of two rectangles that is in both.
double overlap(const cv::Rect& a, const cv::Rect& b) {
  const double both = (a & b).area();
  return both / (a.area() + b.area() - both);
}

const cv::Rect kFirst(305, 125, 110, 260);

/// Calls `take` with each frame. Returns their number; 0 when there is no such video or it cannot be read.
size_t each_frame(const std::function<void(size_t, const cv::Mat&)>& take) {
  if (!std::filesystem::exists(kVideo)) return 0;
  const testing::TemporaryFolder folder;
  const std::string video = folder / "cup.mp4";
  if (std::system((std::string("gzip -dc ") + kVideo + " > " + video).c_str()) != 0) return 0;
  cv::VideoCapture capture(video);
  cv::Mat frame;
  size_t frames = 0;
  for (; capture.isOpened() && capture.read(frame); ++frames) take(frames, frame);
  return frames;
}

TEST(Cup, ALearnedColourHoldsItThroughTheVideo) {
  vision::ColourTable colours;
  vision::BlobFinder finder;
  Eigen::Vector2d before(0, 0);
  double area = 0;
  size_t jumps = 0;
  const size_t frames = each_frame([&](size_t k, const cv::Mat& frame) {
    if (k == 0) {
      const vision::LearnedColour learned = vision::learn_colour(frame, kFirst);
      ASSERT_EQ(learned.status, vision::LearnedColour::Status::kLearned) << description(learned.status);
      EXPECT_TRUE(learned.by_brightness);
      colours = vision::ColourTable(learned.model);
    }
    const vision::FoundBlobs found = finder.find(frame, {0, 0, frame.cols, frame.rows}, colours);
    ASSERT_FALSE(found.blobs.empty()) << "frame " << k;
    const vision::Blob& cup = found.blobs[0];
    if (k % 27 == 0) {
      EXPECT_GT(overlap(cup.box, kByEye[k / 27]), 0.75) << "frame " << k << ": " << cup.box;
    }
    // In between it moves by little.
    if (k > 0) jumps += (cup.centroid - before).norm() < 40 && std::abs(cup.area / area - 1) < 0.2 ? 0 : 1;
    before = cup.centroid;
    area = cup.area;
    const double next = found.blobs.size() > 1 ? found.blobs[1].area : 0;
    EXPECT_LT(next, 0.4 * found.blobs[0].area) << "frame " << k;
  });
  if (frames == 0) GTEST_SKIP() << kVideo << " cannot be read: install opencv-doc";
  EXPECT_EQ(frames, 217U);
  EXPECT_EQ(jumps, 0U);
}

TEST(Cup, IsTrackedInSpace) {
  // As if a second camera stood beside the first and the cup were flat: everything is at the same depth.
  constexpr int kDisparity = 10;
  vision::TrackerOptions options;
  options.rig.left = {.width = 640, .height = 480, .fx = 600, .fy = 600, .cx = 320, .cy = 240, .distortion = {}};
  options.rig.right = options.rig.left;
  options.rig.X_RL = options.rig.X_WL = Eigen::Isometry3d::Identity();
  options.rig.X_RL.translation().x() = -0.06;
  const double depth = 600 * 0.06 / kDisparity;
  std::optional<vision::StereoVision> stage;
  size_t tracked = 0;
  const size_t frames = each_frame([&](size_t k, const cv::Mat& frame) {
    if (k == 0) {
      options.colour.fill(vision::learn_colour(frame, kFirst).model);
      stage.emplace(std::vector{options});
    }
    cv::Mat shifted(frame.size(), CV_8UC3, cv::Scalar(200, 200, 200));
    frame.colRange(kDisparity, frame.cols).copyTo(shifted.colRange(0, frame.cols - kDisparity));
    const auto utime = static_cast<int64_t>(k) * 33333;
    vision::DecodedImages images({utime, utime, utime}, frame, shifted);
    stage->update(images);
    const vision::TargetReport& report = stage->targets().front().report;
    if (report.status != vision::TargetTrack::Status::kTracked) {
      ADD_FAILURE() << "frame " << k << ": " << report.reason;
      return;
    }
    ++tracked;
    EXPECT_NEAR(report.estimate.position.z(), depth, 0.05) << "frame " << k;
  });
  if (frames == 0) GTEST_SKIP() << kVideo << " cannot be read: install opencv-doc";
  EXPECT_EQ(tracked, 217U);
}

}  // namespace
}  // namespace multireach
