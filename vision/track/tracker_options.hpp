#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "imaging/stereo_rig.hpp"
#include "vision/colour/colour_model.hpp"
#include "vision/stereo/stereo_match.hpp"
#include "vision/track/search_region.hpp"
#include "vision/track/target_track.hpp"

namespace multireach::vision {

/// Options of the tracker of one coloured object.
struct TrackerOptions {
  StereoRig rig;
  std::array<ColourModel, 2> colour;  ///< of the left and the right camera
  MatchOptions match;
  TargetTrack::Options track;
  double sigma_px = 0;       ///< standard deviation of additional error of every image point, e.g. calibration error
  double min_area_px = 30;   ///< smaller blobs are ignored
  bool adapt_colour = true;  ///< follow slow changes of white balance
  std::optional<SearchRegion> search_region{};  ///< the target is only there; without it, anywhere
};

/// The part of an image, pixels, that is searched for a target whose position is not known: the whole, or what shows
/// the search region.
cv::Rect search_area(const TrackerOptions& options, Side side);

/// Throws std::invalid_argument for cameras without size or focal length, no baseline, a right camera that is not to
/// the right of the left one, sizes and thresholds that are not positive, and a search region that a camera does not
/// see.
void require_valid(const TrackerOptions& options);

}  // namespace multireach::vision
