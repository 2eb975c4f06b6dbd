#include "vision/matching/matched_size.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace multireach::vision {
namespace {

/// Radius of the matched object's contour, m, in the image where it is smaller.
double radius_by_contour(const PairContext& pair, const StereoMatch& match) {
  const StereoRig& rig = pair.options.rig;
  const Eigen::Vector3d p_L = rig.X_WL.inverse() * match.point.p_W;
  return std::min(pair.left.contours[static_cast<size_t>(match.left)].value.z() * p_L.norm(),
                  pair.right.contours[static_cast<size_t>(match.right)].value.z() * (rig.X_RL * p_L).norm());
}

}  // namespace

bool tells_size(const PairContext& pair, const StereoMatch& match) {
  return !(pair.options.match.radius_m > 0) && !pair.left.contours[static_cast<size_t>(match.left)].cut_off &&
         !pair.right.contours[static_cast<size_t>(match.right)].cut_off;
}

double radius_by_area(const PairContext& pair, const StereoMatch& match) {
  const StereoRig& rig = pair.options.rig;
  const Eigen::Vector3d p_L = rig.X_WL.inverse() * match.point.p_W;
  const auto radius_m = [](const SphereContour& contour, const CameraModel& camera, double distance_m) {
    return std::sqrt(contour.area / std::numbers::pi / (camera.fx * camera.fy)) * distance_m;
  };
  return std::min(radius_m(pair.left.contours[static_cast<size_t>(match.left)], rig.left, p_L.norm()),
                  radius_m(pair.right.contours[static_cast<size_t>(match.right)], rig.right, (rig.X_RL * p_L).norm()));
}

void add_occlusion_covariance(const PairContext& pair, StereoMatch& match) {
  if (!has_position(match.status) || !tells_size(pair, match)) return;
  const UnoccludedSize& size = pair.object.unoccluded_size;
  if (match.both_by_contour) {
    // A contour that is much smaller than the object is that of a round piece of it, as between the fingers of a hand.
    const double radius_m = radius_by_contour(pair, match);
    if (pair.options.match.max_size_ratio * radius_m < size.radius_m())
      match.shape_covariance += size.occlusion_covariance(radius_m, pair.times.pair);
    return;
  }
  const double radius_m = radius_by_area(pair, match);
  match.shape_covariance += size.occlusion_covariance(radius_m, pair.times.pair);
  if (pair.left.wider() || pair.right.wider()) match.shape_covariance += size.surplus_covariance(radius_m);
}

}  // namespace multireach::vision
