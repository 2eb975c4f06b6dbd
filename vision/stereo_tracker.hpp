#pragma once

#include <array>

#include "imaging/side.hpp"
#include "vision/camera_check/calibration_check.hpp"
#include "vision/camera_check/camera_motion.hpp"
#include "vision/colour/colour_background.hpp"
#include "vision/colour/find.hpp"
#include "vision/colour/illumination.hpp"
#include "vision/pair_times.hpp"
#include "vision/stereo/stereo_match.hpp"
#include "vision/track/candidates.hpp"
#include "vision/track/search_region.hpp"
#include "vision/track/target_identity.hpp"
#include "vision/track/target_track.hpp"
#include "vision/track/unoccluded_size.hpp"

namespace multireach::vision {

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

/// What was found of one target in one image of a pair.
struct View {
  bool fits = false;    ///< the image is 8-bit BGR and has the size of the calibration
  bool dark = false;    ///< nothing was found in the whole search area, and it is black
  bool filled = false;  ///< most of the search area has the target's colour
  bool wider = false;   ///< searched with the wider colour model
  bool full = false;    ///< as many blobs were found as are measured: there may be more
  cv::Rect window;      ///< search window
  cv::Mat bgr;          ///< the image; shares its pixels
  std::vector<Blob> blobs;
  std::vector<SphereContour> contours;  ///< one per blob
  std::vector<Appearance> appearance;   ///< likewise
};

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

/// What a pair shows of the other targets that look like one.
struct OtherTargets {
  std::array<std::vector<bool>, 2> taken{};  ///< for each blob of the views, whether it is another target; or empty
  size_t sought = 1;            ///< how many targets that look like this one are looked for, itself included
  bool unknown = false;         ///< there are others, but which blobs they are is not known yet
  size_t sought_elsewhere = 1;  ///< the same, of those that are not where they are expected
  bool anywhere = false;        ///< this target is looked for wherever it may be, not where its motion takes it
};

/// Tracks one coloured object through stereo pairs, in the steps that StereoVision needs for several objects: for each
/// pair expire(), measure() for both images, match(), then update() or update_unseen(). Deterministic: its
/// whole state between pairs is what serialize() returns, except the diagnostics
/// calibration_disagreement() and camera_shift().
class StereoTracker {
 public:
  /// Throws std::invalid_argument for invalid options: no colour, cameras without size or focal length, no baseline, a
  /// right camera that is not to the right of the left one, a search region that a camera does not see.
  explicit StereoTracker(const TrackerOptions& options);

  const TrackerOptions& options() const { return options_; }
  /// Forgets all pairs, as when a log is played again.
  void restart();
  const TargetTrack& track() const { return track_; }
  /// The target is lost: the next match begins a new track.
  void lose_track() { track_.lose(); }
  /// Ends the track, and forgets the target, if too much time has passed without pairs before the one at `utime`. To be
  /// called before it is searched.
  void expire(int64_t utime);
  const TargetIdentity& identity() const { return identity_; }
  /// What does not fit the calibration in the mean of many pairs.
  CalibrationCheck::Disagreement calibration_disagreement() const { return calibration_.disagreement(); }
  /// What was noticed of a camera's motion since the start.
  struct CameraShift {
    std::optional<int64_t> last_utime;  ///< when it moved last, microseconds
    Eigen::Vector3d total_px{0, 0, 0};  ///< of the image, as CameraMotion::moved_px(); about
  };
  const CameraShift& camera_shift(Side side) const { return cameras_[index(side)].shift; }
  cv::Rect whole_image(Side side) const;
  /// The part of an image that is searched for a target whose position is not known: the whole, or what shows the
  /// search region.
  cv::Rect search_area(Side side) const { return cameras_[index(side)].area; }
  /// Search window for a pair at time `utime`: around the predicted position, or the search area.
  cv::Rect window(Side side, int64_t utime) const;
  /// Where a confirmed target that was tracked shortly before is expected; nothing of another one.
  std::optional<cv::Rect> predicted_window(Side side, int64_t utime) const;
  /// Which colours count as the target's: those learned, or also those near them. The latter are enough where little
  /// else can be meant: in the small window in which a confirmed target is expected.
  enum class Colours { kLearned, kWider };
  /// Finds and measures the object's blobs in the part `window` of an 8-bit BGR image. The image must be valid there
  /// and must live until update(). The two sides may be processed concurrently. `chroma_subsampled`: see StereoImages.
  View measure(Side side, const cv::Mat& bgr, const cv::Rect& window, bool chroma_subsampled = false,
               Colours colours = Colours::kLearned);
  /// A match with the candidates that it was chosen from, best first. Where several could be the target, its status is
  /// kAmbiguous and it is the best one.
  struct Found {
    StereoMatch match;
    std::vector<Candidate> candidates;
    std::optional<StereoMatch> replaces{};  ///< the match of the followed object, which `match` is to replace
  };
  /// Matches and triangulates the two views. Does not change the tracker.
  Found match(const PairTimes& times, const View& left, const View& right, const OtherTargets& others = {}) const;
  /// Of the object: the known one, else as measured by the last match; 0 before the first.
  double radius_m() const { return radius_m_; }
  /// Whether the target is expected somewhere in this pair.
  bool is_expected(const PairTimes& times) const { return history_at(times).manoeuvring.has_value(); }
  /// Where the target's centre is expected in both images, pixels, if it moves steadily.
  std::optional<std::array<Eigen::Vector2d, 2>> expected_px(const PairTimes& times) const;
  /// Where a match is not about where the target is expected, but exactly one image shows a blob there that is like it:
  /// the target is where it was expected, and the match is another thing. (Where both images show one, the pair was
  /// compared as well, and the choice among candidates stands.) The status names the image in which the target is
  /// missing. `others`: boxes of the targets that look like it, in both images.
  std::optional<StereoMatch::Status> seen_in_one_image(const PairTimes& times, const StereoMatch& match,
                                                       const View& left, const View& right,
                                                       const std::array<std::vector<cv::Rect>, 2>& others) const;
  /// Whether the windows sufficed, so that the search areas need not be searched: the object was matched where the
  /// track expects it, and lies completely inside both windows.
  bool is_inside_windows(const PairTimes& times, const StereoMatch& match, const View& left, const View& right) const;
  /// Whether a match by the learned colours missed a target that can be looked for again with the wider ones, in both
  /// predicted windows.
  bool may_look_again(int64_t utime, const StereoMatch& match) const;
  /// Whether what was found with the wider colours is the target: of its size, and round.
  bool is_target_again(const Found& found, const View& left, const View& right) const;
  /// Updates the track and the white balance with a pair. `match` is the match of these views. `others`: what encloses
  /// other targets that look like this one in the left and the right image, and is no background.
  TargetReport update(const PairTimes& times, const StereoMatch& match, const View& left, const View& right,
                      const std::array<std::vector<cv::Rect>, 2>& others = {});
  /// Updates the track with a pair that has no usable match. `reason` must be a string literal: it is not copied.
  TargetReport update_unseen(int64_t utime, const char* reason);

  /// Matches a single pair by searching the search areas; the pair does not update the track.
  Found find(const cv::Mat& left_bgr, const cv::Mat& right_bgr, bool chroma_subsampled = false);

  /// The state after a pair at time `utime`, which may be older than the pairs before.
  std::vector<double> serialize(int64_t utime) const;
  /// Restores the state that serialize(utime) returned. Returns false, and changes nothing, when `state` is not valid.
  [[nodiscard]] bool deserialize(int64_t utime, std::span<const double> state);

 private:
  struct CameraState {
    CameraState(const CameraModel& camera, const ColourModel& colour, double least_seen, const cv::Rect& searched)
        : area(searched),
          learned(colour),
          model(colour),
          wider(wider_model(colour)),
          fitter(camera, least_seen),
          background({camera.width, camera.height}),
          motion(searched.size()) {}
    cv::Rect area;        // that is searched
    ColourTable learned;  // without white-balance gains
    AdaptedColourModel model, wider;
    WhiteBalanceGains gains;
    BlobFinder finder;
    SphereContourFitter fitter;
    ColourBackground background;
    CameraMotion motion;
    CameraShift shift;   // no state: for people
    int looks = 0;       // at the search area, up to the number that suffices to begin with
    int since_look = 0;  // pairs
  };

  static constexpr int kMaxBlobs = 6;         // measured per image
  static constexpr int kFirstLooks = 16;      // search areas that a new tracker searches to learn the background
  static constexpr int kLookEvery = 8;        // pairs between two searches of a whole area for the background
  static constexpr double kWorthwhile = 0.5;  // above this share of the search area, all of it is searched instead
  static constexpr double kTargetRadii = 2;   // around where the target was seen last: no background is learned
  static ColourModel wider_model(const ColourModel& model);
  static CameraState camera_state(const TrackerOptions& options, Side side);
  StereoRig rig_at(const PairTimes& times) const;
  PositionEstimate estimate_at_pair(const PairTimes& times, const StereoMatch& match) const;
  TargetReport report(int64_t utime, TargetTrack::Status status, const char* reason) const;
  TargetReport unseen(int64_t utime, const char* reason);
  void adapt(Side side, const View& view, int chosen, double quality);
  bool learned_colours_show_more(Side side, const View& view, const Blob& blob);
  bool has_bounced(int64_t utime, const PositionEstimate& there, const StereoMatch& match, const View& left,
                   const View& right, const std::array<std::vector<cv::Rect>, 2>& others) const;
  TargetReport update_track(const PairTimes& times, const StereoMatch& match, const View& left, const View& right,
                            const std::array<std::vector<cv::Rect>, 2>& others);
  void notice_motion(Side side, const View& view, int64_t utime);
  void learn_background(Side side, const View& view, int chosen, std::vector<cv::Rect> objects,
                        bool others_are_background);
  double lead_against_found_again() const;
  bool may_replace(const StereoMatch& other, const StereoMatch& tracked, const View& left, const View& right) const;
  /// What takes part in a match.
  struct MatchScope {
    bool background = false;                ///< contours that the remembered background explains
    bool prediction = false;                ///< the target's motion
    const StereoMatch* followed = nullptr;  ///< the tracked object, even if it is unlike the target; null: none
    double lead = kLead;                    ///< evidence by which the best candidate must exceed the others
  };
  Found match_elsewhere(const PairTimes& times, const View& left, const View& right, const OtherTargets& others) const;
  Found match_among(const PairTimes& times, const View& left, const View& right, const OtherTargets& others,
                    const MatchScope& scope) const;
  /// Refuses the chosen candidate for a target that is not tracked, where it is unlikely to be the target. `located`:
  /// how many other targets the images show.
  void check_first_match(size_t chosen, std::span<const ComparedPair> pairs, size_t located, const View& left,
                         const View& right, Found& found) const;
  TargetHistory history_at(const PairTimes& times) const;
  void add_occlusion(int64_t utime, const View& left, const View& right, StereoMatch& match) const;
  bool tells_size(const StereoMatch& match, const View& left, const View& right) const;
  /// Radius of a disc of the matched object's area, and of its contour, in the image where it is smaller, m.
  double radius_by_area(const StereoMatch& match, const View& left, const View& right) const;
  double radius_by_contour(const StereoMatch& match, const View& left, const View& right) const;
  /// Where the target is expected, in the frames of the left and of the right camera, if it is before both.
  std::optional<std::array<Eigen::Vector3d, 2>> expected_in_cameras(const PairTimes& times) const;

  TrackerOptions options_;
  std::array<CameraState, 2> cameras_;
  TargetTrack track_;
  TargetIdentity identity_;
  double radius_m_ = 0;  // of the object, from the last match
  UnoccludedSize unoccluded_size_;
  Eigen::Matrix3d shape_covariance_ = Eigen::Matrix3d::Zero();  // of the last match: as uncertain is what coasts
  CalibrationCheck calibration_;
};

}  // namespace multireach::vision
