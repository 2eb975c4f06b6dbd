#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "vision/stereo/stereo_match.hpp"
#include "vision/track/candidates.hpp"
#include "vision/track/pair_times.hpp"
#include "vision/track/tracked_object.hpp"
#include "vision/track/tracker_options.hpp"

namespace multireach::vision {

// Where a tracked object is predicted in a pair of images.

/// The rig with the object's motion between the two exposures compensated: the right camera is shifted by the opposite
/// motion, so that both images show the object at the time of the left one.
StereoRig motion_compensated_rig(const TrackerOptions& options, const TrackedObject& object, const PairTimes& times);

/// What is known of the object at the time of the left image, to which motion_compensated_rig() refers a match. Empty
/// after the time at which the object counts as lost.
TargetHistory history_at(const TrackerOptions& options, const TrackedObject& object, const PairTimes& times);

/// Where the object is if it moves steadily, m, in the frames of the left and of the right camera; nothing where it is
/// not in front of both.
std::optional<std::array<Eigen::Vector3d, 2>> predicted_in_cameras(const TrackerOptions& options,
                                                                   const TrackedObject& object, const PairTimes& times);
/// The same in both images, pixels.
std::optional<std::array<Eigen::Vector2d, 2>> predicted_px(const TrackerOptions& options, const TrackedObject& object,
                                                           const PairTimes& times);

/// The part of an image, pixels, in which to search for the object in a pair at time `utime`, us. Nothing where the
/// object is not confirmed, or was not tracked shortly before. `search_area`: of this camera, pixels.
std::optional<cv::Rect> predicted_window(const TrackerOptions& options, const TrackedObject& object, Side side,
                                         const cv::Rect& search_area, int64_t utime);

/// The matched position at the pair's time, m, in W. The covariance, m^2, is the one that the track uses; it contains
/// the unknown motion between the exposures.
PositionEstimate estimate_at_pair(const TrackerOptions& options, const TrackedObject& object, const PairTimes& times,
                                  const StereoMatch& match);

}  // namespace multireach::vision
