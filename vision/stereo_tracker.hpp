#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "imaging/side.hpp"
#include "vision/camera_check/calibration_check.hpp"
#include "vision/camera_search.hpp"
#include "vision/matching/elsewhere.hpp"
#include "vision/matching/target_match.hpp"
#include "vision/pair_times.hpp"
#include "vision/tracked_object.hpp"
#include "vision/tracker_options.hpp"
#include "vision/view.hpp"

namespace multireach::vision {

/// Tracking result after a pair.
struct TargetReport {
  TargetTrack::Status status = TargetTrack::Status::kLost;
  PositionEstimate estimate;  ///< in W; measured from this pair when tracked, predicted when coasting
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();             ///< m/s, in W
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Zero();  ///< (m/s)^2
  std::optional<int64_t> last_seen_utime;                         ///< time of the last accepted match, microseconds
  const char* reason = "";                                        ///< why the target has this status, as text
  bool ambiguous = false;  ///< this pair shows several things that could be the target; a position is not to be used
};

/// Tracks one coloured object through stereo pairs, in the steps that StereoVision needs for several objects: for each
/// pair expire(), measure() for both images, match(), then update() or update_unseen(). Deterministic: its
/// whole state between pairs is what serialize() returns, except the diagnostics
/// calibration_disagreement() and camera_shift().
class StereoTracker {
 public:
  /// Throws std::invalid_argument for options that checked() refuses.
  explicit StereoTracker(const TrackerOptions& options);

  const TrackerOptions& options() const { return options_; }
  /// Forgets all pairs, as when a log is played again.
  void restart();
  const TargetTrack& track() const { return object_.track; }
  /// The target is lost: the next match begins a new track.
  void lose_track() { object_.track.lose(); }
  /// Ends the track, and forgets the target, if too much time has passed without pairs before the one at `utime`. To be
  /// called before it is searched.
  void expire(int64_t utime);
  const TargetIdentity& identity() const { return object_.identity; }
  /// What does not fit the calibration in the mean of many pairs.
  CalibrationCheck::Disagreement calibration_disagreement() const { return calibration_.disagreement(); }
  const CameraShift& camera_shift(Side side) const { return cameras_[index(side)].shift(); }
  cv::Rect whole_image(Side side) const { return cameras_[index(side)].whole_image(); }
  /// The part of an image that is searched for a target whose position is not known: the whole, or what shows the
  /// search region.
  cv::Rect search_area(Side side) const { return cameras_[index(side)].area(); }
  /// Search window for a pair at time `utime`: around the predicted position, or the search area.
  cv::Rect window(Side side, int64_t utime) const;
  /// Where a confirmed target that was tracked shortly before is expected; nothing of another one.
  std::optional<cv::Rect> predicted_window(Side side, int64_t utime) const;
  /// See CameraSearch::measure(). The image must live until update(). The two sides may be processed concurrently.
  View measure(Side side, const cv::Mat& bgr, const cv::Rect& window, bool chroma_subsampled = false,
               Colours colours = Colours::kLearned);
  /// Matches and triangulates the two views. Does not change the tracker.
  TargetMatch match(const PairTimes& times, const View& left, const View& right, const OtherTargets& others = {}) const;
  /// Of the object: the known one, else as measured by the last match; 0 before the first.
  double radius_m() const { return object_.radius_m; }
  /// Whether the target is expected somewhere in this pair.
  bool is_expected(const PairTimes& times) const;
  /// Where the target's centre is expected in both images, pixels, if it moves steadily.
  std::optional<std::array<Eigen::Vector2d, 2>> expected_px(const PairTimes& times) const;
  /// Where a match is another thing, for one image shows the target where it is expected: see the function of this
  /// name.
  std::optional<StereoMatch::Status> seen_in_one_image(const PairTimes& times, const StereoMatch& match,
                                                       const View& left, const View& right,
                                                       const BoxesOfOthers& others) const;
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
  std::array<CameraSearch, 2> cameras_;
  TrackedObject object_;
  CalibrationCheck calibration_;
};

}  // namespace multireach::vision
