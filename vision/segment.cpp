#include "vision/segment.hpp"

#include <opencv2/imgproc.hpp>
#include <vector>

namespace multireach::vision {

std::optional<Blob> largest_blob(const cv::Mat& mask, double min_area) {
  cv::Mat cleaned;
  cv::morphologyEx(mask, cleaned, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3}));
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(cleaned, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  std::optional<Blob> best;
  for (const std::vector<cv::Point>& outline : outlines) {
    // The outline runs through the centres of the border pixels: Pick's theorem gives the number of pixels inside.
    const double polygon = cv::contourArea(outline);
    const double area = polygon + static_cast<double>(outline.size()) / 2 + 1;
    if (area < min_area || polygon <= 0 || (best && area <= best->area)) continue;
    const cv::Moments moments = cv::moments(outline);
    const cv::Rect box = cv::boundingRect(outline);
    best = Blob{.centroid = {moments.m10 / moments.m00, moments.m01 / moments.m00},
                .area = area,
                .cut_off = box.x == 0 || box.y == 0 || box.br().x == mask.cols || box.br().y == mask.rows};
  }
  return best;
}

}  // namespace multireach::vision
