#pragma once

#include <optional>
#include <span>

#include "vision/contour/disc_measure.hpp"
#include "vision/stereo/triangulate.hpp"

namespace multireach::vision {

/// What was found in one pair of images.
struct Sighting {
  enum class Status {
    kSeen,
    kWrongImageSize,  ///< an image is not of the size that the calibration is for
    kLeftDark,        ///< an image is black
    kRightDark,
    kColourEverywhere,  ///< most of an image is of the colour
    kNotInLeft,         ///< no blob of the colour
    kNotInRight,
    kCutOff,              ///< too much is outside an image
    kNotTheSame,          ///< the two images show things of different size, or in different places
    kLinesOfSightMissed,  ///< one good disc of the same size in each image, but their lines of sight pass each other
    kBehindCameras,       ///< the rays do not meet in front of the cameras
    kExchanged,           ///< they would if the left and the right image were exchanged
    kHiddenTooMuch,       ///< too much is hidden for its middle to be told
    kOfOtherSize,         ///< not of the radius that is known
    kNotWhereExpected,    ///< not where the prediction says, although something is seen elsewhere
  };
  Status status = Status::kNotInLeft;
  /// Where it is. Meaningful when seen; `p_W` and `covariance` also when kHiddenTooMuch, kOfOtherSize,
  /// kNotWhereExpected or kCutOff (for a filter that gates by covariance); `epipolar_error_px` also when kNotTheSame or
  /// kLinesOfSightMissed.
  SphereTriangulation point;
  Eigen::Vector2d left_px{0, 0}, right_px{0, 0};  ///< images of its centre, pixels
  int left = -1, right = -1;                      ///< which of the measurements were taken; -1 for none
  double hidden = 0;                              ///< the larger share hidden or cut off of both discs
  bool both_by_edges = false;                     ///< both measured by their outlines
  /// The right ray's distance from the left ray, signed (+: it passes below in the left image), in pixels of the left
  /// camera, and its standard deviation. Its mean over many frames is 0 for a good calibration, whatever is seen.
  double epipolar_px = 0, epipolar_sigma_px = 0;
  /// It does not fit, but would if the left and the right image were exchanged.
  bool fits_exchanged = false;
};

/// A sentence for people.
const char* description(Sighting::Status status);

/// How the object is told from what is not.
struct SightingOptions {
  double radius_m = 0;            ///< of the sphere; 0 where it is not known or the object is no sphere
  double radius_tolerance_m = 0;  ///< standard deviation of `radius_m`
  double max_epipolar_px = 3;     ///< beyond what the measurements' own errors explain (three standard deviations)
  double max_size_ratio = 1.35;   ///< of the radii at the same place, beyond what their errors explain
  double max_hidden = 0.22;       ///< share of the disc
  double max_prediction_sigmas = 5;
};

/// Where the object is expected, in W.
struct Prediction {
  Eigen::Vector3d p_W;
  Eigen::Matrix3d covariance;
};

/// Chooses the pair of measurements, one of each image, that shows the object, and where that is. A pair must lie on
/// one epipolar line, in front of the cameras, and be of one size; of several, the one nearest to the prediction is
/// taken (when there is one), and then the larger and rounder one. When none fits, the status says what is wrong with
/// the best.
Sighting sight(const StereoRig& rig, std::span<const DiscMeasurement> left, std::span<const DiscMeasurement> right,
               const std::optional<Prediction>& prediction, const SightingOptions& options);

}  // namespace multireach::vision
