#include "vision/matching/matched_size.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace multireach::vision {
namespace {

/// Radius of the matched object's contour, m, in the image where it is smaller.
double radius_by_contour(const StereoRig& rig, const StereoMatch& match, const View& left, const View& right) {
  const Eigen::Vector3d p_L = rig.X_WL.inverse() * match.point.p_W;
  return std::min(left.contours[static_cast<size_t>(match.left)].value.z() * p_L.norm(),
                  right.contours[static_cast<size_t>(match.right)].value.z() * (rig.X_RL * p_L).norm());
}

}  // namespace

bool has_position(StereoMatch::Status status) {
  using Status = StereoMatch::Status;
  return status == Status::kSeen || status == Status::kOccludedTooMuch || status == Status::kCutOff ||
         status == Status::kWrongRadius || status == Status::kOutsidePredictionGate;
}

bool tells_size(const TrackerOptions& options, const StereoMatch& match, const View& left, const View& right) {
  return !(options.match.radius_m > 0) && !left.contours[static_cast<size_t>(match.left)].cut_off &&
         !right.contours[static_cast<size_t>(match.right)].cut_off;
}

double radius_by_area(const StereoRig& rig, const StereoMatch& match, const View& left, const View& right) {
  const Eigen::Vector3d p_L = rig.X_WL.inverse() * match.point.p_W;
  const auto radius_m = [](const SphereContour& contour, const CameraModel& camera, double distance_m) {
    return std::sqrt(contour.area / std::numbers::pi / (camera.fx * camera.fy)) * distance_m;
  };
  return std::min(radius_m(left.contours[static_cast<size_t>(match.left)], rig.left, p_L.norm()),
                  radius_m(right.contours[static_cast<size_t>(match.right)], rig.right, (rig.X_RL * p_L).norm()));
}

// Where the border of an image cuts the object off, the match's covariance has that already. A contour that is much
// smaller than the object is that of a round piece of it, as between the fingers of a hand.
void add_occlusion(const TrackerOptions& options, const UnoccludedSize& size, int64_t utime, const View& left,
                   const View& right, StereoMatch& match) {
  if (!has_position(match.status) || !tells_size(options, match, left, right)) return;
  if (match.both_by_contour) {
    const double radius_m = radius_by_contour(options.rig, match, left, right);
    if (options.match.max_size_ratio * radius_m < size.radius_m())
      match.shape_covariance += size.occlusion_covariance(radius_m, utime);
    return;
  }
  const double radius_m = radius_by_area(options.rig, match, left, right);
  match.shape_covariance += size.occlusion_covariance(radius_m, utime);
  // The wider colours may also show some of what is beside the object.
  if (left.wider() || right.wider()) match.shape_covariance += size.surplus_covariance(radius_m);
}

}  // namespace multireach::vision
