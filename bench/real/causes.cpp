#include "bench/real/causes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace multireach::bench {
namespace {

using Status = vision::TargetTrack::Status;

/// What the left image shows of the object nearest to a label: the distance of the nearest measured blob's centre, and
/// its radius.
struct Nearest {
  double px = 1e9, radius_px = 0;
};

Nearest nearest_blob(const vision::View& view, const std::vector<cv::Point2d>& labels) {
  Nearest nearest;
  for (const vision::SphereContour& contour : view.contours) {
    for (const cv::Point2d& label : labels) {
      const double px = std::hypot(contour.centre_px.x() - label.x, contour.centre_px.y() - label.y);
      if (px < nearest.px) nearest = {px, contour.radius_px};
    }
  }
  return nearest;
}

std::string cause_of(const vision::StereoVision::Target& target, const std::vector<cv::Point2d>& labels,
                     int disparity_px) {
  const Nearest nearest = nearest_blob(target.views[0], labels);
  if (target.report.status == Status::kTracked) {
    double px = 1e9;
    for (const cv::Point2d& label : labels)
      px = std::min(px, std::hypot(target.match.left_px.x() - label.x, target.match.left_px.y() - label.y));
    const std::string by = target.match.both_by_contour ? "contour" : "centroid";
    if (px <= kWrong) return "answered: " + by + " 10 to 25 px off";
    return nearest.px <= kRight ? "answered: another thing, the object is a blob too" : "answered: another thing";
  }
  const bool inside = std::ranges::any_of(
      labels, [&](const cv::Point2d& label) { return label.x - std::max(nearest.radius_px, 3.0) >= disparity_px; });
  if (!inside) return "no answer: the shift cuts the object off the second image";
  const std::string reason = target.report.reason;
  if (nearest.px <= kRight) return "no answer, blob right: " + reason;
  if (nearest.px <= std::max(kWrong, nearest.radius_px)) return "no answer, blob's centre off: " + reason;
  return "no answer, no blob of the object: " + reason;
}

}  // namespace

void Causes::add(const vision::StereoVision::Target& target, const std::vector<cv::Point2d>& labels, int disparity_px) {
  ++images_[cause_of(target, labels, disparity_px)];
}

void Causes::add(const Causes& other) {
  for (const auto& [cause, count] : other.images_) images_[cause] += count;
}

void Causes::print(const std::string& set, const std::string& object, int labelled) const {
  std::vector<std::pair<int, std::string>> sorted;
  for (const auto& [cause, count] : images_) sorted.emplace_back(count, cause);
  std::ranges::sort(sorted, std::greater<>());
  for (const auto& [count, cause] : sorted)
    std::printf("| %s | %s | %s | %.1f |\n", set.c_str(), object.c_str(), cause.c_str(),
                labelled > 0 ? 100.0 * count / labelled : 0);
}

}  // namespace multireach::bench
