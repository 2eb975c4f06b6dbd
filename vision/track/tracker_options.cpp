#include "vision/track/tracker_options.hpp"

#include <stdexcept>

namespace multireach::vision {
namespace {

constexpr int kLeastArea = 16;  // pixels, width and height of a search area

}  // namespace

cv::Rect search_area(const TrackerOptions& options, Side side) {
  const CameraModel& camera = options.rig.camera(side);
  if (!options.search_region) return {0, 0, camera.width, camera.height};
  const Eigen::Vector3d radius = Eigen::Vector3d::Constant(options.match.radius_m);
  const SearchRegion whole_ball(options.search_region->min() - radius, options.search_region->max() + radius);
  const Eigen::Isometry3d X_LW = options.rig.X_WL.inverse();
  return search_area(whole_ball, camera, side == Side::kLeft ? X_LW : options.rig.X_RL * X_LW);
}

void require_valid(const TrackerOptions& options) {
  const auto require = [](bool sensible, const char* sentence) {
    if (!sensible) throw std::invalid_argument(sentence);
  };
  require_usable(options.rig);
  // Position of the right camera in the left camera's frame.
  require(options.rig.X_RL.inverse().translation().x() > 0,
          "the right camera is to the left of the left one: the images are swapped, or the baseline's sign is wrong");
  const MatchOptions& match = options.match;
  require(match.radius_m >= 0 && match.radius_tolerance_m >= 0 && options.sigma_px >= 0 && options.min_area_px > 0 &&
              match.max_epipolar_px > 0 && match.max_size_ratio > 1 && match.max_occlusion > 0 &&
              match.max_prediction_sigmas > 0,
          "the tracker's sizes and thresholds must be positive");
  if (options.search_region) {
    require((options.search_region->sizes().array() > 0).all() && options.search_region->sizes().allFinite(),
            "search_region_m: each number of min must be less than that of max");
    const auto sees = [&](Side side) {
      const cv::Rect area = search_area(options, side);
      return area.width >= kLeastArea && area.height >= kLeastArea;
    };
    require(sees(Side::kLeft), "the left camera does not see search_region_m");
    require(sees(Side::kRight), "the right camera does not see search_region_m");
  }
}

}  // namespace multireach::vision
