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

bool shows_more_than_learned(const PairContext& pair, const StereoMatch& match) {
  return pair.left.shows_more_than_learned(match.left) || pair.right.shows_more_than_learned(match.right);
}

double radius_by_area(const PairContext& pair, const StereoMatch& match, Shown shown) {
  const StereoRig& rig = pair.options.rig;
  const Eigen::Vector3d p_L = rig.X_WL.inverse() * match.point.p_W;
  const auto radius_m = [shown](const View& view, int at, const CameraModel& camera, double distance_m) {
    const double area = (shown == Shown::kAll ? view.blobs : view.seeds)[static_cast<size_t>(at)].area;
    return std::sqrt(area / std::numbers::pi / (camera.fx * camera.fy)) * distance_m;
  };
  return std::min(radius_m(pair.left, match.left, rig.left, p_L.norm()),
                  radius_m(pair.right, match.right, rig.right, (rig.X_RL * p_L).norm()));
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
  // What it was grown by may be something else: then the rest is occluded.
  const double learned_m = radius_by_area(pair, match, Shown::kByLearnedColours);
  match.shape_covariance += size.occlusion_covariance(learned_m, pair.times.pair);
  const double all_m = radius_by_area(pair, match, Shown::kAll);
  if (shows_more_than_learned(pair, match) || size.is_suddenly_larger(all_m, pair.times.pair))
    match.shape_covariance += size.surplus_covariance(all_m);
}

}  // namespace multireach::vision
