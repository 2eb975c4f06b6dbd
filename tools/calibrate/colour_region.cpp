#include "tools/calibrate/colour_region.hpp"

#include <opencv2/imgproc.hpp>

namespace multireach {

cv::Rect region_around(const cv::Mat& bgr, const cv::Point& click) {
  constexpr int kApart = 30;    // grey levels; largest difference from the clicked colour, in each channel
  constexpr int kSmallest = 4;  // pixels; smallest half size of the patch
  const cv::Rect whole({0, 0}, bgr.size());
  cv::Mat mask = cv::Mat::zeros(bgr.rows + 2, bgr.cols + 2, CV_8UC1);
  cv::Mat smooth;
  cv::GaussianBlur(bgr, smooth, {5, 5}, 0);
  cv::Rect patch;
  cv::floodFill(smooth, mask, click, {}, &patch, cv::Scalar::all(kApart), cv::Scalar::all(kApart),
                4 | cv::FLOODFILL_MASK_ONLY | cv::FLOODFILL_FIXED_RANGE);
  return (patch | cv::Rect(click.x - kSmallest, click.y - kSmallest, 2 * kSmallest + 1, 2 * kSmallest + 1)) & whole;
}

}  // namespace multireach
