#include "vision/segment.hpp"

#include <opencv2/imgproc.hpp>
#include <vector>

namespace multireach::vision {

std::optional<Eigen::Vector2d> polygon_centroid(const std::vector<Eigen::Vector2d>& polygon) {
  if (polygon.empty()) return std::nullopt;
  // Relative to one of its points, so that a small polygon far from the origin loses no digits.
  const Eigen::Vector2d origin = polygon.front();
  double twice_area = 0;
  Eigen::Vector2d moment(0, 0);
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d a = polygon[i] - origin, b = polygon[(i + 1) % polygon.size()] - origin;
    const double cross = a.x() * b.y() - a.y() * b.x();
    twice_area += cross;
    moment += cross * (a + b);
  }
  if (twice_area == 0) return std::nullopt;
  return origin + moment / (3 * twice_area);
}

std::optional<OutlinedBlob> largest_blob(const cv::Mat& mask, double min_area) {
  cv::Mat cleaned;
  cv::morphologyEx(mask, cleaned, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3}));
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(cleaned, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  const std::vector<cv::Point>* largest = nullptr;
  double largest_area = min_area;
  for (const std::vector<cv::Point>& outline : outlines) {
    // The outline runs through the centres of the border pixels: Pick's theorem gives the number of pixels inside.
    const double area = cv::contourArea(outline) + static_cast<double>(outline.size()) / 2 + 1;
    if (area < largest_area) continue;
    largest = &outline;
    largest_area = area;
  }
  if (!largest) return std::nullopt;
  OutlinedBlob blob;
  blob.area = largest_area;
  for (const cv::Point& pixel : *largest) blob.outline.emplace_back(pixel.x, pixel.y);
  const auto centroid = polygon_centroid(blob.outline);
  if (!centroid) return std::nullopt;
  blob.centroid = *centroid;
  const cv::Rect box = cv::boundingRect(*largest);
  blob.cut_off = box.x == 0 || box.y == 0 || box.br().x == mask.cols || box.br().y == mask.rows;
  return blob;
}

}  // namespace multireach::vision
