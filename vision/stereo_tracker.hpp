#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "imaging/side.hpp"
#include "vision/camera_check/calibration_check.hpp"
#include "vision/matching/target_match.hpp"
#include "vision/object_detector.hpp"
#include "vision/track/pair_times.hpp"
#include "vision/track/target_report.hpp"
#include "vision/track/tracked_object.hpp"
#include "vision/track/tracker_options.hpp"
#include "vision/track/view.hpp"

namespace multireach::vision {

/// Tracks one coloured object through stereo pairs, in the steps that StereoVision needs for several objects: for each
/// pair expire(), measure() for both images, match(), then update() or update_unseen(). Deterministic: its
/// whole state between pairs is what serialize() returns, except the diagnostics
/// calibration_disagreement() and camera_shift().
class StereoTracker {
 public:
  /// Throws std::invalid_argument for options that require_valid() refuses, a colour model that check() refuses, and
  /// options of the track that TargetTrack refuses.
  explicit StereoTracker(const TrackerOptions& options);

  const TrackerOptions& options() const { return options_; }
  /// Forgets all pairs, as when a log is played again.
  void restart();
  /// What is known of the object. Free functions tell from it where the object is expected (track/object_prediction).
  const TrackedObject& object() const { return object_; }
  const TargetTrack& track() const { return object_.track; }
  /// The target is lost: the next match begins a new track.
  void lose_track() { object_.track.lose(); }
  /// Ends the track, and forgets the target, if too much time has passed without pairs before the one at `utime`. To be
  /// called before it is searched.
  void expire(int64_t utime);
  const TargetIdentity& identity() const { return object_.identity; }
  /// What does not fit the calibration in the mean of many pairs.
  CalibrationCheck::Disagreement calibration_disagreement() const { return calibration_.disagreement(); }
  const CameraShift& camera_shift(Side side) const { return detectors_[index(side)].shift(); }
  cv::Rect whole_image(Side side) const { return detectors_[index(side)].whole_image(); }
  /// See search_area() of the options.
  cv::Rect search_area(Side side) const { return detectors_[index(side)].search_area(); }
  /// Search window for a pair at time `utime`: around the predicted position, or the search area.
  cv::Rect window(Side side, int64_t utime) const;
  /// Where a confirmed target that was tracked shortly before is expected; nothing of another one.
  std::optional<cv::Rect> predicted_window(Side side, int64_t utime) const;
  /// See ObjectDetector::measure(). Where a confirmed target of unknown size is expected at `utime`, blobs of its
  /// colours grow. The image must live until update(). The two sides may be processed concurrently.
  View measure(Side side, int64_t utime, const cv::Mat& bgr, const cv::Rect& window, bool chroma_subsampled = false,
               Colours colours = Colours::kLearned);
  /// Matches and triangulates the two views. Does not change the tracker.
  TargetMatch match(const PairTimes& times, const View& left, const View& right, const OtherTargets& others = {}) const;
  /// Whether the windows sufficed, so that the search areas need not be searched: the object was matched where the
  /// track expects it, and lies completely inside both windows.
  bool is_inside_windows(const PairTimes& times, const StereoMatch& match, const View& left, const View& right) const;
  /// Whether a match by the learned colours missed a target that can be looked for again with the wider ones, in both
  /// predicted windows.
  bool may_look_again(int64_t utime, const StereoMatch& match) const;
  /// Updates the track and the white balance with a pair. `match` is the match of these views. `others`: what encloses
  /// other targets that look like this one, and is no background.
  TargetReport update(const PairTimes& times, const StereoMatch& match, const View& left, const View& right,
                      const BoxesOfOthers& others = {});
  /// Updates the track with a pair that has no usable match. `reason` must be a string literal: it is not copied.
  TargetReport update_unseen(int64_t utime, const char* reason);

  /// Matches a single pair by searching the search areas; the pair does not update the track.
  TargetMatch find(const cv::Mat& left_bgr, const cv::Mat& right_bgr, bool chroma_subsampled = false);

  /// The state after a pair at time `utime`, which may be older than the pairs before.
  std::vector<double> serialize(int64_t utime) const;
  /// Restores the state that serialize(utime) returned. Returns false, and changes nothing, when `state` is not valid.
  [[nodiscard]] bool deserialize(int64_t utime, std::span<const double> state);

 private:
  TargetReport report(int64_t utime, TargetTrack::Status status, const char* reason) const;
  TargetReport unseen(int64_t utime, const char* reason);
  TargetReport update_track(const PairTimes& times, const StereoMatch& match, const View& left, const View& right,
                            const BoxesOfOthers& others);
  void learn_from(const PairTimes& times, const StereoMatch& match, const View& left, const View& right);
  void learn_background(Side side, const View& view, int chosen, std::vector<cv::Rect> objects,
                        bool others_are_background);

  TrackerOptions options_;
  std::array<ObjectDetector, 2> detectors_;  // of the left and the right camera
  TrackedObject object_;
  CalibrationCheck calibration_;
};

}  // namespace multireach::vision
