#pragma once

#include <array>

#include "imaging/side.hpp"
#include "vision/colour/find.hpp"
#include "vision/colour/light.hpp"
#include "vision/stereo/stereo_sighting.hpp"
#include "vision/track/target_track.hpp"

namespace multireach::vision {

struct TrackerOptions {
  StereoRig rig;
  std::array<ColourModel, 2> colour;  ///< of the left and the right camera
  SightingOptions sighting;
  TargetTrack::Options track;
  double sigma_px = 0;       ///< standard deviation of every image point beyond what measuring it explains: calibration
  double min_area_px = 30;   ///< smaller blobs are not the object
  bool adapt_colour = true;  ///< follows slow changes of the light
};

/// When the images of a pair were taken, microseconds.
struct PairTimes {
  int64_t pair = 0;  ///< the time that the pair is said to be of
  int64_t left = 0, right = 0;
};

/// What one image of a pair shows of one target.
struct View {
  bool fits = false;    ///< the image is of the size and kind that the calibration is for
  bool dark = false;    ///< nothing was found, and the image is black all over
  bool filled = false;  ///< most of the image is of the target's colour
  cv::Rect window;      ///< where it was looked for
  cv::Mat bgr;          ///< the image; shares its pixels
  std::vector<Blob> blobs;
  std::vector<DiscMeasurement> discs;  ///< of each blob
};

/// What is said of a target after a pair.
struct TargetReport {
  TargetTrack::Status status = TargetTrack::Status::kLost;
  PlaceEstimate place;  ///< in W; when tracked, what this pair shows; when coasting, what is expected
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();             ///< m/s, in W
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Zero();  ///< m^2/s^2
  std::optional<int64_t> seen_utime;                              ///< of the last sighting, microseconds
  const char* reason = "";                                        ///< in words
};

/// Follows one coloured object through stereo pairs. The same pairs give the same answers; memory() is all that it
/// carries from one pair to the next.
class StereoTracker {
 public:
  /// Throws std::invalid_argument for options that make no sense: no colour, cameras without size or focal length, no
  /// baseline, a right camera that is not to the right of the left one.
  explicit StereoTracker(const TrackerOptions& options);

  const TrackerOptions& options() const { return options_; }
  /// To be called before a pair is looked at. Forgets everything when the pair is more than a second before the last
  /// one, as when a log is played again, and then returns true.
  bool begin(int64_t utime);
  cv::Rect whole_image(Side side) const;
  /// Where the object is to be looked for in a pair of time `utime`: where it is expected, or in the whole image.
  cv::Rect window(Side side, int64_t utime) const;
  /// What the part `window` of an 8-bit BGR image shows. The image must be valid there and live until the pair is
  /// taken. Both sides may be looked at at the same time.
  View look(Side side, const cv::Mat& bgr, const cv::Rect& window);
  /// Where in space that is. Changes nothing.
  Sighting sight(const PairTimes& times, const View& left, const View& right) const;
  /// Whether nothing is to be gained by looking at the whole images: it is seen, and whole.
  bool enough(const Sighting& sighting, const View& left, const View& right) const;
  /// Concludes a pair. `sighting` is that of these views.
  TargetReport take(const PairTimes& times, const Sighting& sighting, const View& left, const View& right);
  /// Concludes a pair that could not be looked at. `reason` is a literal.
  TargetReport take_unseen(int64_t utime, const char* reason);

  /// What a single pair shows, whatever came before.
  Sighting find(const cv::Mat& left_bgr, const cv::Mat& right_bgr);

  /// After a pair of time `utime`, which need not have been later than those before.
  std::vector<double> memory(int64_t utime) const;
  /// Goes on from a memory() after the pair of time `utime`. Returns false, and changes nothing, when `memory` is none.
  bool restore(int64_t utime, std::span<const double> memory);

 private:
  struct Eye {
    Eye(const CameraModel& camera, const ColourModel& colour, double least_seen)
        : model(colour), measurer(camera, least_seen) {}
    LitModel model;
    ColourShift shift;
    Finder finder;
    DiscMeasurer measurer;
  };

  static Eye eye(const TrackerOptions& options, Side side);
  StereoRig rig_at(const PairTimes& times) const;
  PlaceEstimate place_at_pair(const PairTimes& times, const Sighting& sighting) const;
  TargetTrack::Status unseen_status() const;
  TargetReport report(TargetTrack::Status status, const char* reason) const;
  void adapt(Side side, const View& view, int chosen, double quality);

  TrackerOptions options_;
  std::array<Eye, 2> eyes_;
  TargetTrack track_;
  double radius_m_ = 0;  // as last seen
};

}  // namespace multireach::vision
