#include "bench/real/baseline.hpp"

#include <algorithm>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace multireach::bench {

Baseline::Baseline(const cv::Mat& bgr, const cv::Point& click) {
  cv::Mat hsv;
  cv::cvtColor(bgr, hsv, cv::COLOR_BGR2HSV);
  clicked_hue_ = hsv.at<cv::Vec3b>(click)[0];
  turn(hsv);
  constexpr int kHalf = 2;
  const cv::Rect patch =
      cv::Rect(click.x - kHalf, click.y - kHalf, 2 * kHalf + 1, 2 * kHalf + 1) & cv::Rect({0, 0}, bgr.size());
  cv::Vec3d median;
  for (int k = 0; k < 3; ++k) {
    cv::Mat channel;
    cv::extractChannel(hsv(patch), channel, k);
    std::vector<uint8_t> values(channel.begin<uint8_t>(), channel.end<uint8_t>());
    std::ranges::nth_element(values, values.begin() + static_cast<ptrdiff_t>(values.size() / 2));
    median[k] = values[values.size() / 2];
  }
  constexpr double kHue = 10;
  low_ = {median[0] - kHue, median[1] / 2, median[2] / 2};
  high_ = {median[0] + kHue, 255, 255};
}

void Baseline::widen(const Baseline& other) {
  // Its hues are turned by another angle, of which the nearer way round counts.
  const double turned = (other.clicked_hue_ - clicked_hue_ + 270) % 180 - 90;
  low_ = {std::min(low_[0], other.low_[0] + turned), std::min(low_[1], other.low_[1]),
          std::min(low_[2], other.low_[2])};
  high_[0] = std::max(high_[0], other.high_[0] + turned);
}

void Baseline::turn(cv::Mat& hsv) const {
  for (int row = 0; row < hsv.rows; ++row) {
    auto* pixels = hsv.ptr<cv::Vec3b>(row);
    for (int column = 0; column < hsv.cols; ++column)
      pixels[column][0] = static_cast<uint8_t>((pixels[column][0] - clicked_hue_ + 270) % 180);
  }
}

std::vector<Baseline::Contour> Baseline::contours(const cv::Mat& bgr) const {
  cv::Mat hsv, mask;
  cv::cvtColor(bgr, hsv, cv::COLOR_BGR2HSV);
  turn(hsv);
  cv::inRange(hsv, low_, high_, mask);
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5}));
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  std::vector<Contour> contours;
  for (const auto& outline : outlines) {
    const cv::Moments m = cv::moments(outline);
    if (m.m00 > 0) contours.push_back({{m.m10 / m.m00, m.m01 / m.m00}, m.m00});
  }
  std::ranges::stable_sort(contours, std::greater<>(), &Contour::area_px);
  return contours;
}

std::vector<cv::Point2d> largest(const std::vector<Baseline::Contour>& contours, size_t most) {
  std::vector<cv::Point2d> centres;
  for (size_t k = 0; k < std::min(most, contours.size()); ++k) centres.push_back(contours[k].centre);
  return centres;
}

}  // namespace multireach::bench
