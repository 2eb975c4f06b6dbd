#include "vision/stereo/compare_contours.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "imaging/rig_errors.hpp"

namespace multireach::vision {
namespace {

using Status = StereoMatch::Status;
using enum SphereContour::Kind;

constexpr double kSigmas = 3;  // every gate is widened by this many sigmas of the measurements' errors
// Systematic error of the measured radius, from blur and bloom, pixels.
constexpr double kRadiusBlur = 0.1;

// A known radius and the distance contradict each other from this share on, besides kSigmas of their errors: a baseline
// or focal length that is off by this much is a calibration to be made again.
constexpr double kSizeError = 0.04;

// Variance of a contour's direction, in variances of a size error whose cause is on one side. A half circle whose edges
// are off by d moves the centre by 0.64 d and the radius by 0.5 d. Half a disc's centroid is 0.42 of its radius from
// its centre, and its size by area 0.29 smaller.
constexpr double kOneSided = 2;

// Weighted root mean square of an arc's residuals, pixels, from which on its edges are not on one circle. Rendered arcs
// of partly occluded balls have up to 0.3, boxes around real balls 0.5 to 0.7.
constexpr double kNoCircle = 0.4;

constexpr double kBlobBlur = 0.1;    // share of its radius by which blur may make a ball's blob larger: a choice
constexpr double kOtherLens = 0.02;  // largest difference between two cameras of one make, share of the image width

/// Signed distance between two viewing rays and its standard deviation, in pixels of the left camera.
struct Gap {
  double px, sigma_px;
};

Gap gap_of(const StereoRig& rig, const SphereContour& left, const SphereContour& right, double depth_left_m,
           double depth_right_m) {
  const Eigen::Vector3d a = left.ray().homogeneous();
  const Eigen::Vector3d b = rig.X_RL.linear().transpose() * right.ray().homogeneous();
  Eigen::Vector3d normal = a.cross(b).normalized();
  if (normal.y() < 0) normal = -normal;  // y is down
  const double gap_m = rig.X_RL.inverse().translation().dot(normal);
  const Eigen::Vector2d in_left = normal.head<2>(), in_right = (rig.X_RL.linear() * normal).head<2>();
  const double variance = depth_left_m * depth_left_m * in_left.dot(left.ray_covariance() * in_left) +
                          depth_right_m * depth_right_m * in_right.dot(right.ray_covariance() * in_right);
  const double px_per_m = rig.left.fx / depth_left_m;
  return {gap_m * px_per_m, std::sqrt(variance) * px_per_m};
}

/// Whether two sizes differ by no more than the ratio allows plus kSigmas of their errors.
bool agree(double first, double first_sigma, double second, double second_sigma, double ratio) {
  const double sigma = std::sqrt(first_sigma * first_sigma + second_sigma * second_sigma);
  return std::abs(first - second) <= (ratio - 1) * std::min(first, second) + kSigmas * sigma;
}

/// A contour as a measurement. If the other image shows no contour, what occludes, moves or deforms the object there
/// may also bias this one: its covariance then covers the blob's centroid, too.
SphereMeasurement sphere_of(const SphereContour& contour, const SphereContour& other) {
  SphereMeasurement sphere{contour.value, contour.covariance, contour.shared};
  if (contour.kind == kEdges && other.kind == kCentroid)
    sphere.covariance += contour.from_centroid * contour.from_centroid.transpose();
  return sphere;
}

/// The size, as in SphereContour::value, that a contour of a sphere at this depth has.
double size_at(double radius_m, const SphereContour& contour, double depth_m) {
  return radius_m / (depth_m * contour.ray().homogeneous().norm());
}

class ContourComparison {
 public:
  ContourComparison(const StereoRig& rig, const std::optional<Prediction>& prediction, const MatchOptions& options)
      : rig_(rig), prediction_(prediction), options_(options) {}

  /// Where the edges of an arc contradict the known radius, as those of a box around the object, the pair may fit by
  /// the blob's centroid.
  ComparedPair operator()(const SphereContour& left, const SphereContour& right) const {
    const ComparedPair scored = compare(left, right);
    const bool arcs = left.by_centroid || right.by_centroid;
    if (!(options_.radius_m > 0) || scored.match.status == Status::kSeen || !arcs) return scored;
    const auto point = triangulate(rig_, {left.ray(), left.ray_covariance()}, {right.ray(), right.ray_covariance()});
    if (!point) return scored;
    const RadiusPrior known = *prior_at(*point);
    const bool keep_left = !contradicts_radius(left, known, point->depth_left_m);
    const bool keep_right = !contradicts_radius(right, known, point->depth_right_m);
    if (keep_left && keep_right) return scored;
    const ComparedPair with_centroids =
        compare(keep_left ? left : *left.by_centroid, keep_right ? right : *right.by_centroid);
    return with_centroids.match.status == Status::kSeen || with_centroids.cut_off_blob ? with_centroids : scored;
  }

 private:
  ComparedPair compare(const SphereContour& left, const SphereContour& right) const {
    ComparedPair scored;
    StereoMatch& match = scored.match;
    match.left_px = left.centre_px;
    match.right_px = right.centre_px;
    const bool known = left.occlusion >= 0 && right.occlusion >= 0;
    const double most = std::max(left.occlusion, right.occlusion);
    match.occlusion = known || most >= BlobCentre::kNotLocated ? most : SphereContour::kUnknown;
    match.both_by_contour = left.kind == kEdges && right.kind == kEdges;
    scored.radius_px = std::min(left.radius_px, right.radius_px);
    scored.score = scored.radius_px * (1 + left.visible_fraction + right.visible_fraction);

    const auto start = triangulate(rig_, {left.ray(), left.ray_covariance()}, {right.ray(), right.ray_covariance()});
    if (!start) {
      match.status = Status::kBehindCameras;
      // Widen the gate: if the images are swapped, each contour was computed with the other camera's calibration.
      match.fits_swapped = fits(right, left, kOtherLens * rig_.left.width);
      return scored;
    }
    const Gap gap = gap_of(rig_, left, right, start->depth_left_m, start->depth_right_m);
    match.epipolar_px = gap.px;
    match.epipolar_sigma_px = gap.sigma_px;
    static_cast<Triangulation&>(match.point) = *start;
    scored.size_sigmas = size_sigmas(left, right, *start);
    const double off = gap.px / gap.sigma_px;
    scored.score /= 1 + off * off / (kSigmas * kSigmas);
    if (!same_size(left, right, *start) || !on_one_line(gap) || miss_the_object(gap, scored) ||
        !projects_onto_both(*start, left, right)) {
      const bool contours = match.both_by_contour && same_size(left, right, *start);
      match.status = contours ? Status::kEpipolarMismatch : Status::kInconsistentPair;
      match.fits_swapped = fits(right, left, 0);
      return scored;
    }
    locate(left, right, scored);
    return scored;
  }

  /// Whether an arc is not the object's contour, but its blob may be the object: the edges do not lie on one circle,
  /// the fitted size contradicts the known radius at this depth, and the blob's size does not.
  bool contradicts_radius(const SphereContour& arc, const RadiusPrior& known, double depth_m) const {
    if (!arc.by_centroid || arc.residual_px < kNoCircle) return false;
    const double expected = size_at(known.radius_m, arc, depth_m);
    const double sigma = known.sigma_m / known.radius_m * expected;
    const double blob = arc.by_centroid->value.z();
    return !agree(arc.value.z(), std::sqrt(arc.covariance(2, 2)), expected, sigma, 1 + kSizeError) &&
           std::max(blob, expected) < options_.max_size_ratio * std::min(blob, expected);
  }

  /// Whether too much of an object is occluded to locate its centre. Where three quarters of a contour's length are
  /// visible (kOfAnything, which is asked of a contour without a known radius) they locate it, whatever the blob lacks:
  /// an edge that hides the other quarter leaves nine tenths of the area, so colours that were not learned are missing.
  bool too_little(const SphereContour& contour) const {
    const bool well_seen = contour.kind == kEdges && contour.visible_fraction >= SphereContourFitter::kOfAnything;
    const bool located = contour.occlusion < BlobCentre::kNotLocated;
    return !located || (contour.occlusion > options_.max_occlusion && !well_seen);
  }

  /// Prior of the radius at a position; nothing when the radius is not known. Errors of the calibration change the
  /// measured radius of an object.
  std::optional<RadiusPrior> prior_at(const Triangulation& point) const {
    if (!(options_.radius_m > 0)) return std::nullopt;
    const double focal = rig_.left.focal_px();
    const double blur_m = kRadiusBlur * point.depth_left_m / focal;
    const double tolerance2 = options_.radius_tolerance_m * options_.radius_tolerance_m;
    const double by_rig2 = options_.radius_m * options_.radius_m * size_variance_by_rig_errors(rig_, point.p_W);
    return RadiusPrior{options_.radius_m, std::sqrt(blur_m * blur_m + tolerance2 + by_rig2)};
  }

  /// Triangulates the sphere of a pair whose contours agree, and checks the position.
  void locate(const SphereContour& left, const SphereContour& right, ComparedPair& scored) const {
    StereoMatch& match = scored.match;
    const auto prior = prior_at(match.point);
    const auto free = triangulate_sphere(rig_, sphere_of(left, right), sphere_of(right, left), std::nullopt);
    const auto sphere = prior ? triangulate_sphere(rig_, sphere_of(left, right), sphere_of(right, left), prior) : free;
    if (!sphere || !free) {
      match.status = Status::kBehindCameras;
      return;
    }
    match.point = *sphere;
    scored.radius_m = free->radius_m;
    scored.radius_sigma_m = free->radius_sigma_m;
    (prior ? match.point.covariance : match.model_covariance) +=
        covariance_of_contradiction(left, right, *free, {match.epipolar_px, match.epipolar_sigma_px});
    if (!prior) {
      match.model_covariance += covariance_by_rays(left, right, sphere->p_W);
      match.shape_covariance += covariance_of_alternative(left, right, *free);
    }
    if (prior) {
      match.size_share = free->radius_m / prior->radius_m - 1;
      match.size_sigma =
          std::sqrt(free->radius_sigma_m * free->radius_sigma_m + prior->sigma_m * prior->sigma_m) / prior->radius_m;
    }
    match.status = Status::kSeen;
    const bool only_part = too_little(left) || too_little(right);
    if (prediction_) {
      const Eigen::Vector3d apart = sphere->p_W - prediction_->p_W;
      Eigen::Matrix3d total = match.point.covariance + prediction_->covariance;
      if (match.both_by_contour) total += prediction_->bias_covariance;
      const double distance2 = apart.dot(total.ldlt().solve(apart));
      scored.score /= 1 + distance2;
      scored.outside_gate = !(distance2 <= options_.max_prediction_sigmas * options_.max_prediction_sigmas);
      if (scored.outside_gate) match.status = Status::kOutsidePredictionGate;
    }
    // Good enough to continue a track, not by itself to start one.
    const bool cut_off_blob = !prediction_ && (left.is_cut_off_blob() || right.is_cut_off_blob());
    if (prior && (is_too_large(left, free->depth_left_m) || is_too_large(right, free->depth_right_m))) {
      match.status = Status::kWrongRadius;
    } else if (only_part && (left.cut_off || right.cut_off)) {
      match.status = Status::kCutOff;
    } else if (only_part) {
      match.status = Status::kOccludedTooMuch;
    } else if (prior && (!has_known_size(*free, *prior, match.both_by_contour) ||
                         other_size(left, free->depth_left_m) || other_size(right, free->depth_right_m))) {
      match.status = cut_off_blob ? Status::kCutOff : Status::kWrongRadius;
    } else if (!projects_onto_both(match.point, left, right)) {
      match.status = cut_off_blob ? Status::kCutOff : Status::kInconsistentPair;
    } else if (cut_off_blob) {
      match.status = Status::kCutOff;
      scored.cut_off_blob = true;
    }
  }

  /// A contour whose size is not that of the known radius has its edges at wrong places on one side, which moves its
  /// centre by about as much as its radius (stripes, an occluder of like colour, a shadow). A blob that is too small
  /// shows a part of the object, whose centroid is as far from its centre. Where the radius is not known, the other
  /// image tells the size, and either may be wrong; two contours need no such comparison, for their covariances tell.
  /// Rays that miss each other by more than their errors (a moving object, unsynchronised cameras) are off by as much
  /// along the epipolar line. Covariance of the position from such errors, by the contradiction beyond the errors of
  /// the rig, of a contour's size and of a known radius; the errors of a blob's size are not known.
  Eigen::Matrix3d covariance_of_contradiction(const SphereContour& left, const SphereContour& right,
                                              const SphereTriangulation& free, const Gap& gap) const {
    const bool known = options_.radius_m > 0, both_edges = left.kind == kEdges && right.kind == kEdges;
    const double excess = std::max(0.0, std::abs(gap.px) - kSigmas * gap.sigma_px) / rig_.left.fx;
    SphereMeasurement wider_left = sphere_of(left, right), wider_right = sphere_of(right, left);
    for (SphereMeasurement* sphere : {&wider_left, &wider_right})
      sphere->covariance.topLeftCorner<2, 2>() += 0.5 * excess * excess * Eigen::Matrix2d::Identity();
    bool any = excess > 0;
    const double by_rig2 = size_variance_by_rig_errors(rig_, free.p_W);
    const auto widen = [&](SphereMeasurement& sphere, const SphereContour& contour, double depth_m,
                           const SphereContour& other, double other_depth_m) {
      if (!known && both_edges) return;
      const bool by_edges = contour.kind == kEdges;
      const double other_m = other_depth_m * other.ray().homogeneous().norm();
      const double expected = size_at(known ? options_.radius_m : other.value.z() * other_m, contour, depth_m);
      double apart = contour.value.z() - expected;
      if (known && !by_edges && apart > 0) apart = std::max(0.0, apart - kBlobBlur * expected);
      const double tolerance = size_at(options_.radius_tolerance_m, contour, depth_m);
      // A gamma curve that is not known could explain the contradiction, but does not excuse it.
      const double of_gamma = contour.shared(2, kGammaCurve);
      const double own2 = by_edges ? contour.covariance(2, 2) - of_gamma * of_gamma : 0;
      const double excess2 = apart * apart - own2 - tolerance * tolerance - expected * expected * by_rig2;
      if (!(excess2 > 0)) return;
      sphere.covariance.topLeftCorner<2, 2>() += kOneSided * excess2 * Eigen::Matrix2d::Identity();
      any = true;
    };
    widen(wider_left, left, free.depth_left_m, right, free.depth_right_m);
    widen(wider_right, right, free.depth_right_m, left, free.depth_left_m);
    if (!any) return Eigen::Matrix3d::Zero();
    // Both at the same estimate: otherwise the difference may be no covariance.
    return sphere_covariance_at(rig_, free.p_W, free.radius_m, wider_left, wider_right) -
           sphere_covariance_at(rig_, free.p_W, free.radius_m, sphere_of(left, right), sphere_of(right, left));
  }

  /// Both images may show the same part of an object, or the object with something beside it: its centre is then to one
  /// side. The centre of a ball is behind a patch on its front, by the root of the difference of their squared radii.
  /// An object beside something else may be nearer or farther away than both, by how much smaller it is: a choice. By
  /// the image in which it differs more.
  Eigen::Matrix3d covariance_of_alternative(const SphereContour& left, const SphereContour& right,
                                            const SphereTriangulation& free) const {
    const auto deeper = [](const SphereContour& contour) {
      const double size = contour.value.z(), other = contour.alternative_size;
      if (other == 0) return 0.0;
      return other > size ? std::sqrt(other * other - size * size) : other - size;
    };
    const auto variance = [&](const SphereContour& contour, double depth_m) {
      return depth_m * depth_m * (contour.alternative_spread.trace() + deeper(contour) * deeper(contour));
    };
    const bool by_left = variance(left, free.depth_left_m) >= variance(right, free.depth_right_m);
    const SphereContour& contour = by_left ? left : right;
    const Eigen::Vector3d along = deeper(contour) * contour.ray().homogeneous();
    Eigen::Matrix3d by_contour = along * along.transpose();
    by_contour.topLeftCorner<2, 2>() += contour.alternative_spread;
    Eigen::Matrix3d from_camera = rig_.X_WL.linear() * (by_left ? free.depth_left_m : free.depth_right_m);
    if (!by_left) from_camera *= rig_.X_RL.linear().transpose();
    return from_camera * by_contour * from_camera.transpose();
  }

  /// The estimate may move the images of an elongated blob far along it, to where both rays meet, and so wrongly
  /// explain rays that miss each other. It may be off by as much as it differs from the midpoint between the measured
  /// rays, and this by as much as it is from each of them.
  Eigen::Matrix3d covariance_by_rays(const SphereContour& left, const SphereContour& right,
                                     const Eigen::Vector3d& p_W) const {
    const auto points = closest_points(rig_, left.ray(), right.ray());
    if (!points) return Eigen::Matrix3d::Zero();
    const auto& [on_left, on_right] = *points;
    const Eigen::Vector3d apart = p_W - 0.5 * (on_left + on_right), across = 0.5 * (on_left - on_right);
    return apart * apart.transpose() + across * across.transpose();
  }

  /// Whether the radius that contours and distance give is the known one. A centroid's size is a rough estimate.
  bool has_known_size(const SphereTriangulation& free, const RadiusPrior& prior, bool by_contour) const {
    const double ratio = by_contour ? 1 + kSizeError : options_.max_size_ratio;
    return agree(free.radius_m, free.radius_sigma_m, prior.radius_m, prior.sigma_m, ratio);
  }

  /// Whether a contour has by far another size than the known radius at this depth, whatever its errors: it is not the
  /// object's.
  bool other_size(const SphereContour& contour, double depth_m) const {
    if (contour.kind != kEdges) return false;
    const double expected = size_at(options_.radius_m, contour, depth_m);
    return std::max(expected, contour.value.z()) > options_.max_size_ratio * std::min(expected, contour.value.z());
  }

  /// Whether a blob is larger than the known ball at this depth, even one that moved by 2.4 of its radii during the
  /// exposure.
  bool is_too_large(const SphereContour& contour, double depth_m) const {
    constexpr double kMost = 1.6, kPixel = 0.5;  // by that motion the area is 1 + 2.4 * 2 / pi = 1.6^2 times as large
    if (contour.kind != kCentroid) return false;
    const double expected = size_at(options_.radius_m + kSigmas * options_.radius_tolerance_m, contour, depth_m);
    return contour.value.z() > kMost * expected + kPixel / rig_.left.fx;
  }

  /// Whether a position is seen where both contours are, within their errors.
  bool projects_onto_both(const Triangulation& point, const SphereContour& left, const SphereContour& right) const {
    const Eigen::Vector3d p_L = rig_.X_WL.inverse() * point.p_W;
    const auto near = [&](const CameraModel& camera, const Eigen::Vector3d& p_C, const SphereContour& contour) {
      if (!(p_C.z() > 0)) return false;
      const double focal = std::max(camera.fx, camera.fy);
      const double sigma_px = focal * std::sqrt(contour.ray_covariance().trace());
      const double apart_px = focal * (p_C.hnormalized() - contour.ray()).norm();
      return apart_px <= options_.max_epipolar_px + kSigmas * sigma_px;
    };
    return near(rig_.left, p_L, left) && near(rig_.right, rig_.X_RL * p_L, right);
  }
  bool on_one_line(const Gap& gap, double besides_px = 0) const {
    return std::abs(gap.px) <= options_.max_epipolar_px + kSigmas * gap.sigma_px + besides_px;
  }
  /// Whether the rays to the centres of what no prediction supports pass each other by more than its radius. Ragged
  /// blobs have centroids so uncertain that on_one_line() admits such a pair, but it more likely shows two things.
  bool miss_the_object(const Gap& gap, const ComparedPair& pair) const {
    return !prediction_ && std::abs(gap.px) > std::max(options_.max_epipolar_px, pair.radius_px);
  }
  bool same_size(const SphereContour& left, const SphereContour& right, const Triangulation& point) const {
    const double left_m = point.depth_left_m * left.ray().homogeneous().norm();
    const double right_m = point.depth_right_m * right.ray().homogeneous().norm();
    return agree(left.value.z() * left_m, std::sqrt(left.covariance(2, 2)) * left_m, right.value.z() * right_m,
                 std::sqrt(right.covariance(2, 2)) * right_m, options_.max_size_ratio);
  }
  /// Difference of the two radii at a position in standard deviations; what the gate allows besides counts as three.
  double size_sigmas(const SphereContour& left, const SphereContour& right, const Triangulation& point) const {
    const double left_m = point.depth_left_m * left.ray().homogeneous().norm();
    const double right_m = point.depth_right_m * right.ray().homogeneous().norm();
    const double first = left.value.z() * left_m, second = right.value.z() * right_m;
    const double allowed = (options_.max_size_ratio - 1) / kSigmas * std::min(first, second);
    const double variance = left.covariance(2, 2) * left_m * left_m + right.covariance(2, 2) * right_m * right_m;
    return std::abs(first - second) / std::sqrt(variance + allowed * allowed);
  }
  bool fits(const SphereContour& left, const SphereContour& right, double besides_px) const {
    const auto point = triangulate(rig_, {left.ray(), left.ray_covariance()}, {right.ray(), right.ray_covariance()});
    return point && same_size(left, right, *point) &&
           on_one_line(gap_of(rig_, left, right, point->depth_left_m, point->depth_right_m), besides_px);
  }

  const StereoRig& rig_;
  const std::optional<Prediction>& prediction_;
  const MatchOptions& options_;
};

}  // namespace

ComparedPair compare_contours(const StereoRig& rig, const SphereContour& left, const SphereContour& right,
                              const std::optional<Prediction>& prediction, const MatchOptions& options) {
  return ContourComparison(rig, prediction, options)(left, right);
}

double fit_of(const ComparedPair& pair, const MatchOptions& options) {
  const double allowed_px = options.max_epipolar_px / kSigmas;
  const double epipolar2 = pair.match.epipolar_px * pair.match.epipolar_px /
                           (pair.match.epipolar_sigma_px * pair.match.epipolar_sigma_px + allowed_px * allowed_px);
  return -0.5 * (epipolar2 + pair.size_sigmas * pair.size_sigmas);
}

}  // namespace multireach::vision
