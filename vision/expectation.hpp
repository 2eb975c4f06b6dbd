#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "vision/pair_times.hpp"
#include "vision/stereo/stereo_match.hpp"
#include "vision/track/candidates.hpp"
#include "vision/tracked_object.hpp"
#include "vision/tracker_options.hpp"

namespace multireach::vision {

// Where a tracked object is expected in a pair of images.

/// The rig with the object's motion between the two exposures compensated: the right camera is shifted by the opposite
/// motion, so that both images show the object at the time of the left one.
StereoRig rig_at(const StereoRig& rig, const TargetTrack& track, const PairTimes& times);

/// What is known of the object at the time of the left image, to which rig_at() refers a match. A prediction over a
/// time after which the object counts as lost says nothing.
TargetHistory history_at(const TrackerOptions& options, const TrackedObject& object, const PairTimes& times);

/// Where the object is expected if it moves steadily, in the frames of the left and of the right camera, m; nothing
/// where it is not before both.
std::optional<std::array<Eigen::Vector3d, 2>> expected_in_cameras(const TrackerOptions& options,
                                                                  const TrackedObject& object, const PairTimes& times);
/// The same in both images, pixels.
std::optional<std::array<Eigen::Vector2d, 2>> expected_px(const TrackerOptions& options, const TrackedObject& object,
                                                          const PairTimes& times);

/// Where an image shows a confirmed object that was tracked shortly before; nothing of another one.
std::optional<cv::Rect> predicted_window(const TrackerOptions& options, const TrackedObject& object, Side side,
                                         int64_t utime);

/// The matched position, moved to the time of the pair; its covariance is that by which the track weighs it, with the
/// unknown motion between exposures.
PositionEstimate estimate_at_pair(const StereoRig& rig, const TargetTrack& track, const PairTimes& times,
                                  const StereoMatch& match);

}  // namespace multireach::vision
