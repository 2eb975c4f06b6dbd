// Real videos of Debian's opencv-doc: of a camera that stands still before people, and parts of it that move.
#include "vision/camera_check/camera_motion.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

namespace multireach {
namespace {

using vision::CameraMotion;
using Motion = CameraMotion::Motion;

constexpr const char* kStreet = "/usr/share/doc/opencv-doc/examples/data/vtest.avi";

std::vector<cv::Mat> street(int every, int most) {
  cv::VideoCapture video(kStreet);
  std::vector<cv::Mat> frames;
  cv::Mat frame;
  for (int k = 0; static_cast<int>(frames.size()) < most && video.read(frame); ++k) {
    if (k % every == 0) frames.push_back(frame.clone());
  }
  return frames;
}

TEST(CameraMotion, PeopleBeforeAStillCameraAreNone) {
  const std::vector<cv::Mat> frames = street(4, 200);
  if (frames.empty()) GTEST_SKIP() << kStreet << " cannot be read: install opencv-doc";
  CameraMotion motion(frames.front().size());
  for (size_t k = 0; k < frames.size(); ++k)
    EXPECT_EQ(motion.look(frames[k]), Motion::kNone) << k << ": " << motion.moved_px().transpose();
}

TEST(CameraMotion, ExposureIsNone) {
  const std::vector<cv::Mat> frames = street(4, 60);
  if (frames.empty()) GTEST_SKIP() << kStreet << " cannot be read: install opencv-doc";
  CameraMotion motion(frames.front().size());
  for (size_t k = 0; k < frames.size(); ++k) {
    cv::Mat image;
    frames[k].convertTo(image, -1, 1 - 0.4 * (static_cast<double>(k % 20) / 20), 5);
    EXPECT_EQ(motion.look(image), Motion::kNone) << k << ": " << motion.moved_px().transpose();
  }
}

TEST(CameraMotion, AShiftIsNoticedAndMeasured) {
  const std::vector<cv::Mat> frames = street(4, 50);
  if (frames.empty()) GTEST_SKIP() << kStreet << " cannot be read: install opencv-doc";
  // A window of 600 x 440 in the images stands for a camera that turns: cells of 30 pixels, an eighth is 4.
  for (const cv::Point by : {cv::Point(4, 0), cv::Point(0, -4), cv::Point(8, 6), cv::Point(-20, 10)}) {
    CameraMotion motion({600, 440});
    const cv::Rect window(80, 60, 600, 440);
    size_t k = 0;
    for (; k < 20; ++k) EXPECT_EQ(motion.look(frames[k](window)), Motion::kNone);
    // A window that moves to the right shows everything farther to the left. Somebody who walks may hide it for a look.
    while (k < 28 && motion.look(frames[k](window + by)) == Motion::kNone) ++k;
    ASSERT_LT(k, 28U) << by;
    const Eigen::Vector2d expected(-by.x, -by.y), measured = motion.moved_px().head<2>();
    EXPECT_GT(measured.dot(expected), 0.25 * expected.squaredNorm()) << by << measured.transpose();
    if (expected.norm() < 15) {
      EXPECT_LT((measured - expected).norm(), 0.5 * expected.norm()) << by << measured.transpose();
    }
    for (++k; k < frames.size(); ++k)
      EXPECT_EQ(motion.look(frames[k](window + by)), Motion::kNone) << by << k << ": " << motion.moved_px().transpose();
  }
}

TEST(CameraMotion, AnObjectThatPassesIsSeldomTakenForOne) {
  const std::vector<cv::Mat> frames = street(4, 60);
  const cv::Mat aloe = cv::imread("/usr/share/doc/opencv-doc/examples/data/aloeL.jpg");
  if (frames.empty() || aloe.empty()) GTEST_SKIP() << kStreet << " cannot be read: install opencv-doc";
  cv::Mat object;  // of a fifth of the image, full of edges
  cv::resize(aloe, object, {frames.front().cols / 5, frames.front().rows}, 0, 0, cv::INTER_AREA);
  CameraMotion motion(frames.front().size());
  int taken = 0;
  for (size_t k = 0; k < frames.size(); ++k) {
    object.copyTo(frames[k](cv::Rect(6 * static_cast<int>(k), 0, object.cols, object.rows)));
    taken += motion.look(frames[k]) != Motion::kNone;
  }
  EXPECT_LE(taken, 3) << "of 60 looks";
}

TEST(CameraMotion, SlowMotionAddsUpUntilItIsNoticed) {
  const std::vector<cv::Mat> frames = street(4, 100);
  if (frames.empty()) GTEST_SKIP() << kStreet << " cannot be read: install opencv-doc";
  CameraMotion motion({600, 440});
  int noticed = 0;
  for (size_t k = 0; k < frames.size(); ++k)
    noticed += motion.look(frames[k](cv::Rect(20 + static_cast<int>(k) / 2, 60, 600, 440))) != Motion::kNone;
  EXPECT_GE(noticed, 5) << "50 pixels in 100 looks";
}

TEST(CameraMotion, SmallOrBlackImagesSayNothing) {
  CameraMotion small({40, 20}), black({320, 240});
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(small.look(cv::Mat(20, 40, CV_8UC3, cv::Scalar::all(40 * k))), Motion::kNone);
    EXPECT_EQ(black.look(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(0))), Motion::kNone);
  }
}

}  // namespace
}  // namespace multireach
