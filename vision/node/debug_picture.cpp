#include "vision/node/debug_picture.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace multireach::vision {
namespace {

// OpenCV draws in 16ths of a pixel.
constexpr int kBits = 4;

cv::Point sixteenths(const Eigen::Vector2d& pixel) {
  const auto bounded = [](double value) { return cvRound(std::clamp(value, -1e4, 1e4) * (1 << kBits)); };
  return {bounded(pixel.x()), bounded(pixel.y())};
}

void mark(cv::Mat picture, const DebugMarks& target, const DebugMarks::OneSide& side) {
  if (!side.window.empty()) cv::rectangle(picture, side.window, target.colour, 1);
  for (const auto& corners : side.outlines) {
    for (size_t k = 0; k < 4; ++k)
      cv::line(picture, sixteenths(corners[k]), sixteenths(corners[(k + 1) % 4]), target.colour, 2, cv::LINE_AA, kBits);
  }
  for (const DebugMarks::Contour& contour : side.contours) {
    const int radius = cvRound(std::clamp(contour.radius_px, 0.5, 1e4) * (1 << kBits));
    cv::circle(picture, sixteenths(contour.centre_px), radius, target.colour, contour.chosen ? 2 : 1, cv::LINE_AA,
               kBits);
    if (!contour.chosen) continue;
    for (const Eigen::Vector2d& arm : {Eigen::Vector2d(5, 0), Eigen::Vector2d(0, 5)}) {
      cv::line(picture, sixteenths(contour.centre_px - arm), sixteenths(contour.centre_px + arm), target.colour, 1,
               cv::LINE_AA, kBits);
    }
  }
}

}  // namespace

cv::Mat debug_picture(const cv::Mat& left, const cv::Mat& right, const std::vector<DebugMarks>& targets) {
  cv::Mat picture(std::max(left.rows, right.rows), left.cols + right.cols, CV_8UC3, cv::Scalar(0, 0, 0));
  const std::array<cv::Mat, 2> halves{picture(cv::Rect(0, 0, left.cols, left.rows)),
                                      picture(cv::Rect(left.cols, 0, right.cols, right.rows))};
  left.copyTo(halves[0]);
  right.copyTo(halves[1]);
  int baseline = 18;
  for (const DebugMarks& target : targets) {
    for (size_t side = 0; side < 2; ++side) mark(halves[side], target, target.sides[side]);
    // Dark outline first, so that the text is readable on any background.
    for (const auto& [colour, thickness] : {std::pair(cv::Scalar(0, 0, 0), 3), {target.colour, 1}}) {
      cv::putText(picture, target.text, {6, baseline}, cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, thickness, cv::LINE_AA);
    }
    baseline += 18;
  }
  return picture;
}

}  // namespace multireach::vision
