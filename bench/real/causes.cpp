#include "bench/real/causes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bench/real/score.hpp"

namespace multireach::bench {
namespace {

using Status = vision::TargetTrack::Status;

/// What the left image shows of the object at a label: the distance of the nearest measured blob's centre, and its
/// radius.
struct Nearest {
  double px = 1e9, radius_px = 0;
};

double distance_px(const Eigen::Vector2d& px, const cv::Point2d& label) {
  return std::hypot(px.x() - label.x, px.y() - label.y);
}

Nearest nearest_blob(const std::vector<vision::StereoVision::Target>& targets, const cv::Point2d& label) {
  Nearest nearest;
  for (const vision::StereoVision::Target& target : targets) {
    for (const vision::SphereContour& contour : target.views[0].contours) {
      const double px = distance_px(contour.centre_px, label);
      if (px < nearest.px) nearest = {px, contour.radius_px};
    }
  }
  return nearest;
}

std::string cause_of(const std::vector<vision::StereoVision::Target>& targets, const cv::Point2d& label) {
  const Nearest nearest = nearest_blob(targets, label);
  const vision::StereoVision::Target* lost = nullptr;
  for (const vision::StereoVision::Target& target : targets) {
    if (target.report.status != Status::kTracked) {
      if (!lost || target.report.ambiguous) lost = &target;
      continue;
    }
    if (distance_px(target.match.left_px, label) <= kWrong)
      return fmt::format("answered: {} {:.0f} to {:.0f} px off", target.match.both_by_contour ? "contour" : "centroid",
                         kRight, kWrong);
  }
  if (!lost)
    return nearest.px <= kRight ? "answered: another thing, the object is a blob too" : "answered: another thing";
  const std::string reason = lost->report.reason;
  if (nearest.px <= kRight) return "no answer, blob right: " + reason;
  if (nearest.px <= std::max(kWrong, nearest.radius_px)) return "no answer, blob's centre off: " + reason;
  return "no answer, no blob of the object: " + reason;
}

}  // namespace

void Causes::add(const std::vector<vision::StereoVision::Target>& targets, const cv::Point2d& label) {
  ++labels_[cause_of(targets, label)];
}

void Causes::add(const Causes& other) {
  for (const auto& [cause, count] : other.labels_) labels_[cause] += count;
}

void Causes::print(const std::string& set, const std::string& object, int labels) const {
  std::vector<std::pair<int, std::string>> sorted;
  for (const auto& [cause, count] : labels_) sorted.emplace_back(count, cause);
  std::ranges::sort(sorted, std::greater<>());
  for (const auto& [count, cause] : sorted)
    std::printf("| %s | %s | %s | %.1f |\n", set.c_str(), object.c_str(), cause.c_str(),
                labels > 0 ? 100.0 * count / labels : 0);
}

}  // namespace multireach::bench
