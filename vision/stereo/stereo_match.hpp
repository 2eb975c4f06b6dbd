#pragma once

#include <optional>
#include <span>
#include <vector>

#include "vision/contour/sphere_contour.hpp"
#include "vision/stereo/triangulate.hpp"

namespace multireach::vision {

/// Result of matching one stereo pair.
struct StereoMatch {
  enum class Status {
    kSeen,
    kWrongImageSize,  ///< an image does not have the size of the calibration
    kLeftDark,        ///< an image is black
    kRightDark,
    kColourEverywhere,  ///< most of an image has the object's colour
    kNotInLeft,         ///< no blob of the object's colour
    kNotInRight,
    kCutOff,                 ///< too much of the object is outside an image, or too much to start a track
    kMoreAtBorder,           ///< something is more like the target, but the border cuts it off
    kInconsistentPair,       ///< the blobs differ in size or violate the epipolar constraint
    kEpipolarMismatch,       ///< a contour of the same size in each image, but they violate the epipolar constraint
    kBehindCameras,          ///< the viewing rays do not meet in front of the cameras, or no estimate converges
    kNoDistance,             ///< the distance does not exceed its standard deviation
    kImagesSwapped,          ///< the best pair does not fit, but would if left and right image were exchanged
    kOccludedTooMuch,        ///< too much is occluded to locate the centre
    kWrongRadius,            ///< the measured radius differs from the known one
    kOutsidePredictionGate,  ///< something was found, but not at the predicted position
    kOutsideRegion,          ///< something was found, but outside of the search region
    kOnlyBackground,         ///< only objects that were there already while the target was elsewhere
    kUnlike,            ///< only things of another size or more ragged than the target, which was seen shortly before
    kUnlikely,          ///< only specks that are too small and ragged to be taken for the target
    kOffColour,         ///< only things of which no pixel is well inside the target's colours
    kSeveralElsewhere,  ///< several things that may be the target, none of them where it is predicted
    kAmbiguous,         ///< several objects could be the target
    kOtherTarget,       ///< only what another target is that looks alike
    kTogether,          ///< a blob in which this target and another one that looks alike are expected
  };
  Status status = Status::kNotInLeft;
  /// The object's position. Valid when kSeen; `p_W` and `covariance` also when kOccludedTooMuch, kWrongRadius,
  /// kOutsidePredictionGate, kOutsideRegion or kCutOff (for a filter that gates by covariance); `epipolar_error_px`
  /// also when kInconsistentPair or kEpipolarMismatch.
  SphereTriangulation point;
  /// Covariance of `p_W` besides that of `point`, where the radius is not known, of what sizes or rows contradict (a
  /// motion between the exposures). Not in `point`, by which candidates are compared with the prediction, the search
  /// region and each other: the images of two things differ, too. The track's gates and filter use it.
  Eigen::Matrix3d model_covariance = Eigen::Matrix3d::Zero();
  /// The same, of what the object may be more or less than its blob. The track does not weigh the match by it; what is
  /// reported contains it.
  Eigen::Matrix3d shape_covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector2d left_px{0, 0}, right_px{0, 0};  ///< images of the object's centre, pixels
  int left = -1, right = -1;                      ///< indices of the chosen contours; -1 for none
  double occlusion = 0;          ///< share occluded or cut off, the larger of both contours; -1: not known
  bool both_by_contour = false;  ///< both measured by sphere contours, not by centroids
  /// Signed distance of the right ray from the left ray (+: the right ray passes below in the left image), in pixels of
  /// the left camera, and its standard deviation. For a good calibration its mean over many frames is 0.
  double epipolar_px = 0, epipolar_sigma_px = 0;
  /// By which share of the known radius the object looks larger at its distance, and the standard deviation; 0 and 0
  /// where the radius is not known.
  double size_share = 0, size_sigma = 0;
  /// Located as if the object were at rest, since its motion is not known: no prediction supports the match.
  bool unknown_motion = false;
  /// The pair does not fit, but would if the left and the right image were exchanged.
  bool fits_swapped = false;

  /// m^2, of `p_W`: by which the track weighs the match; with what the object may be more or less than its blob; and
  /// of errors that are the same from image to image (PositionEstimate), unless both images show contours.
  Eigen::Matrix3d noise_covariance() const { return point.covariance + model_covariance; }
  Eigen::Matrix3d covariance() const { return noise_covariance() + shape_covariance; }
  Eigen::Matrix3d bias_covariance() const {
    return both_by_contour ? Eigen::Matrix3d::Zero().eval() : noise_covariance();
  }
};

/// The status as a sentence.
const char* description(StereoMatch::Status status);

/// Whether `point.p_W` of a match and its covariance are valid, to compare them with a search region; kOutsideRegion is
/// the result of that.
[[nodiscard]] bool has_position(StereoMatch::Status status);

/// Gates that a match must pass.
struct MatchOptions {
  double radius_m = 0;            ///< of the sphere; 0 where it is unknown or the object is not a sphere
  double radius_tolerance_m = 0;  ///< standard deviation of `radius_m`
  double max_epipolar_px = 3;     ///< epipolar error allowed in addition to three standard deviations
  double max_size_ratio = 1.35;   ///< of the two radii at the triangulated position, in addition to their errors
  double max_occlusion = 0.22;    ///< share of the target's area that is occluded or beyond the border
  double max_prediction_sigmas = 4;
};

/// As description(), of a match that is kSeen: also tells where its viewing rays miss each other by more than
/// `max_epipolar_px`, but by less than that plus three standard deviations.
const char* description_of_seen(const StereoMatch& match, const MatchOptions& options);

/// Predicted position of the object, in W.
struct Prediction {
  Eigen::Vector3d p_W;
  Eigen::Matrix3d covariance;
  /// m^2, of the track's bias (PositionEstimate): added to `covariance` when a pair of contours is compared.
  Eigen::Matrix3d bias_covariance = Eigen::Matrix3d::Zero();
};

/// A pair of contours, one of each image, that was compared.
struct ComparedPair {
  StereoMatch match;
  double score = 0;           ///< among pairs of the same status: see match_candidates()
  double size_sigmas = 0;     ///< difference of the radii that both images show at this position, standard deviations
  bool outside_gate = false;  ///< not where the object is predicted, whatever the status
  double radius_px = 0;       ///< of the smaller image
  double radius_m = 0;        ///< without prior knowledge of the radius; 0 where it was not triangulated
  double radius_sigma_m = 0;
  bool cut_off_blob = false;  ///< kCutOff only because the border cuts a blob off that no prediction supports
  /// Of two objects that look alike, each left contour fits both right ones, and this pair most likely consists of the
  /// left image of one and the right image of the other: it exchanges their order, or fits clearly less.
  bool mixed = false;
};

/// A pair, or a candidate, must exceed others by this difference of log likelihoods: likelihood ratio 20, from which on
/// evidence counts as strong (Kass and Raftery, Bayes Factors, J. Am. Stat. Assoc. 90, 1995, Sect. 3.2).
inline constexpr double kLead = 2.995732273553991;  // ln 20

/// Compares all pairs of contours, left by left. Empty where an image has none.
std::vector<ComparedPair> compare_pairs(const StereoRig& rig, std::span<const SphereContour> left,
                                        std::span<const SphereContour> right,
                                        const std::optional<Prediction>& prediction, const MatchOptions& options);

/// A pair of contours that agree in size and lie up to 2 per cent of the image's width off one epipolar line, where the
/// images show more such pairs, of contours that no pair locates, than pairs that are located: then the calibration is
/// more likely wrong than each image shows other objects, and a pair that is located may show two. Null where there are
/// not so many. `located`: how many things the images show that are located, but not among `pairs`.
[[nodiscard]] const ComparedPair* contradiction_of(std::span<const ComparedPair> pairs, const StereoRig& rig,
                                                   size_t located = 0);

/// Chooses the pair of contours, one of each image, that shows the object, and triangulates it. A pair must satisfy the
/// epipolar constraint, lie in front of the cameras and agree in size. Of several, the score prefers the one near the
/// prediction (when there is one), with large and complete contours. When none fits, the status tells why the best one
/// was rejected.
StereoMatch match_candidates(const StereoRig& rig, std::span<const SphereContour> left,
                             std::span<const SphereContour> right, const std::optional<Prediction>& prediction,
                             const MatchOptions& options);
/// The same for pairs that were compared, or for some of them.
StereoMatch best_match(std::span<const SphereContour> left, std::span<const SphereContour> right,
                       std::span<const ComparedPair> pairs);

}  // namespace multireach::vision
