// A real video: a black cup that a hand turns and moves before a bright wall.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "vision/find.hpp"
#include "vision/learn_colour.hpp"

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

TEST(Cup, ALearnedColourHoldsItThroughTheVideo) {
  if (!std::filesystem::exists(kVideo)) GTEST_SKIP() << kVideo << " is not here: install opencv-doc";
  const std::filesystem::path video =
      std::filesystem::temp_directory_path() / ("cup-" + std::to_string(getpid()) + ".mp4");
  ASSERT_EQ(std::system((std::string("gzip -dc ") + kVideo + " > " + video.string()).c_str()), 0);
  cv::VideoCapture capture(video.string());
  std::filesystem::remove(video);
  if (!capture.isOpened()) GTEST_SKIP() << "this OpenCV cannot read " << kVideo;
  vision::PixelClass colours;
  vision::Finder finder;
  cv::Mat frame;
  Eigen::Vector2d before(0, 0);
  double area = 0;
  size_t frames = 0, jumps = 0;
  for (; capture.read(frame); ++frames) {
    if (frames == 0) {
      const vision::LearnedColour learned = vision::learn_colour(frame, {305, 125, 110, 260});
      ASSERT_EQ(learned.status, vision::LearnedColour::Status::kLearned) << description(learned.status);
      EXPECT_TRUE(learned.by_brightness);
      colours = vision::PixelClass(learned.model);
    }
    const vision::Found found = finder.find(frame, {0, 0, frame.cols, frame.rows}, colours);
    ASSERT_FALSE(found.blobs.empty()) << "frame " << frames;
    const vision::Blob& cup = found.blobs[0];
    if (frames % 27 == 0) {
      EXPECT_GT(overlap(cup.box, kByEye[frames / 27]), 0.75) << "frame " << frames << ": " << cup.box;
    }
    // In between it moves by little.
    if (frames > 0) jumps += (cup.centroid - before).norm() < 40 && std::abs(cup.area / area - 1) < 0.2 ? 0 : 1;
    before = cup.centroid;
    area = cup.area;
    const double next = found.blobs.size() > 1 ? found.blobs[1].area : 0;
    EXPECT_LT(next, 0.4 * found.blobs[0].area) << "frame " << frames;
  }
  EXPECT_EQ(frames, 217U);
  EXPECT_EQ(jumps, 0U);
}

}  // namespace
}  // namespace multireach
