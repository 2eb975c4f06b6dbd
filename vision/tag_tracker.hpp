#pragma once

#include <array>
#include <optional>
#include <string>

#include "imaging/side.hpp"
#include "imaging/stereo_rig.hpp"
#include "vision/fiducial/tag_pose.hpp"
#include "vision/track/pair_times.hpp"
#include "vision/track/target_report.hpp"

namespace multireach::vision {

struct TagOptions {
  StereoRig rig;
  int id = 0;  ///< in the family 36h11
  TagSize size;
  double sigma_px = 0;  ///< standard deviation of additional error of every image point, e.g. calibration error
  TargetTrack::Options track;
};

/// What one image of a pair shows of a tag.
struct TagView {
  cv::Rect window;  ///< search window
  cv::Mat bgr;      ///< the image; shares its pixels
  bool searched = false;
  bool others = false;            ///< tags with other ids were found
  std::vector<FoundTag> matches;  ///< tags with this id
};

/// What a pair shows of a tag.
struct TagMatch {
  std::optional<TagPose> pose;                      ///< in the left camera's frame
  std::optional<Eigen::Vector3d> other_position_L;  ///< position by the mirrored pose, where it fits about as well
  const char* reason = "";                          ///< why there is no pose
  std::array<bool, 2> used{};                       ///< images that the pose comes from
  std::array<Eigen::Vector2d, 2> centre_px{Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 0)};  ///< measured, where used
  double epipolar_error_px = 0;                                                            ///< where both are used
};

/// Tracking result after a pair.
struct TagReport : TargetReport {
  /// Rotation from the tag's frame to W: of this pair when tracked, the last one when coasting. Nothing when the images
  /// allow two orientations.
  std::optional<Eigen::Quaterniond> R_WT;
  Eigen::Matrix3d orientation_covariance = Eigen::Matrix3d::Zero();  ///< rad^2, of a rotation vector in W; when tracked
};

/// Tracks one AprilTag through stereo pairs, in which it may be seen by both cameras or by one: for each pair views,
/// match(), then update() or update_unseen(). Deterministic: its whole state between pairs is what serialize() returns.
class TagTracker {
 public:
  /// Throws std::invalid_argument for invalid options: an id that the family does not have, no size, cameras without
  /// size or focal length, no baseline.
  explicit TagTracker(const TagOptions& options);

  const TagOptions& options() const { return options_; }
  void restart();
  /// Ends the track if the pair at `utime` comes too late for it, see TargetTrack. To be called before it is searched.
  void expire(int64_t utime);
  const TargetTrack& track() const { return track_; }
  cv::Rect whole_image(Side side) const;
  /// Search window for a pair at time `utime`: around the predicted position, or the whole image.
  cv::Rect window(Side side, int64_t utime) const;
  TagMatch match(const PairTimes& times, const std::array<TagView, 2>& views) const;
  TagReport update(const PairTimes& times, const TagMatch& match);
  /// `reason` must be a string literal: it is not copied.
  TagReport update_unseen(int64_t utime, const char* reason);

  /// The state after a pair at time `utime`, which may be older than the pairs before.
  std::vector<double> serialize(int64_t utime) const;
  /// Restores the state that serialize(utime) returned. Returns false, and changes nothing, when `state` is not valid.
  [[nodiscard]] bool deserialize(int64_t utime, std::span<const double> state);

 private:
  TagReport report(int64_t utime, TargetTrack::Status status, const char* reason) const;
  Eigen::Vector3d motion_of(const PairTimes& times, Side side) const;
  std::vector<TagObservation> observations_of(const PairTimes& times, const std::array<TagView, 2>& views,
                                              std::vector<Side>& sides) const;

  TagOptions options_;
  TargetTrack track_;
  std::optional<Eigen::Quaterniond> R_WT_;  // as last seen
};

}  // namespace multireach::vision
