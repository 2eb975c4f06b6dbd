#include "vision/stereo/stereo_sighting.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace multireach::vision {
namespace {

using Status = Sighting::Status;

constexpr double kSigmas = 3;  // of the measurements' own errors, within every gate
// How far a radius as seen is from the ball's own whatever the edges' noise: blur and bloom, pixels.
constexpr double kRadiusBlur = 0.1;

constexpr double kOtherLens = 0.02;  // of an image's width: so much two cameras of one make differ

/// The distance between two lines of sight, signed, and its standard deviation, in pixels of the left camera.
struct Gap {
  double px, sigma_px;
};

Gap gap_of(const StereoRig& rig, const DiscMeasurement& left, const DiscMeasurement& right, double depth_left_m,
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

/// Two sizes agree when they differ by no more than the ratio allows, and their own errors.
bool agree(double first, double first_sigma, double second, double second_sigma, double ratio) {
  const double sigma = std::sqrt(first_sigma * first_sigma + second_sigma * second_sigma);
  return std::abs(first - second) <= (ratio - 1) * std::min(first, second) + kSigmas * sigma;
}

SphereMeasurement sphere_of(const DiscMeasurement& disc) {
  return {disc.value, disc.covariance};
}

/// One pair of measurements: what it would be, and how good that is among pairs of the same status.
struct Judgement {
  Sighting sighting;
  double score = 0;
};

class Judge {
 public:
  Judge(const StereoRig& rig, const std::optional<Prediction>& prediction, const SightingOptions& options)
      : rig_(rig), prediction_(prediction), options_(options) {}

  Judgement operator()(const DiscMeasurement& left, const DiscMeasurement& right) const {
    Judgement judgement;
    Sighting& sighting = judgement.sighting;
    sighting.left_px = left.centre_px;
    sighting.right_px = right.centre_px;
    sighting.hidden = std::max(left.hidden, right.hidden);
    sighting.both_by_edges = left.kind == DiscMeasurement::Kind::kEdges && right.kind == DiscMeasurement::Kind::kEdges;
    judgement.score = std::min(left.radius_px, right.radius_px) * (1 + left.outline_seen + right.outline_seen);

    const auto start = triangulate(rig_, {left.ray(), left.ray_covariance()}, {right.ray(), right.ray_covariance()});
    if (!start) {
      sighting.status = Status::kBehindCameras;
      // Each would have been measured with the other's lens.
      sighting.fits_exchanged = fits(right, left, kOtherLens * rig_.left.width);
      return judgement;
    }
    const Gap gap = gap_of(rig_, left, right, start->depth_left_m, start->depth_right_m);
    sighting.epipolar_px = gap.px;
    sighting.epipolar_sigma_px = gap.sigma_px;
    static_cast<Triangulation&>(sighting.point) = *start;
    const double off = gap.px / gap.sigma_px;
    judgement.score /= 1 + off * off / (kSigmas * kSigmas);
    if (!same_size(left, right, *start) || !on_one_line(gap)) {
      const bool discs = sighting.both_by_edges && same_size(left, right, *start);
      sighting.status = discs ? Status::kLinesOfSightMissed : Status::kNotTheSame;
      sighting.fits_exchanged = fits(right, left, 0);
      return judgement;
    }

    const double focal = std::sqrt(rig_.left.fx * rig_.left.fy);
    const double blur_m = kRadiusBlur * start->depth_left_m / focal;
    const double tolerance_m = std::sqrt(blur_m * blur_m + options_.radius_tolerance_m * options_.radius_tolerance_m);
    std::optional<RadiusPrior> prior;
    if (options_.radius_m > 0) prior = {options_.radius_m, tolerance_m};
    const auto free = triangulate_sphere(rig_, sphere_of(left), sphere_of(right), std::nullopt);
    const auto sphere = prior ? triangulate_sphere(rig_, sphere_of(left), sphere_of(right), prior) : free;
    if (!sphere || !free) {
      sighting.status = Status::kBehindCameras;
      return judgement;
    }
    sighting.point = *sphere;
    sighting.status = Status::kSeen;
    const bool only_part = left.hidden > options_.max_hidden || right.hidden > options_.max_hidden;
    const auto lost_at_border = [](const DiscMeasurement& disc) {
      return disc.cut_off && disc.kind == DiscMeasurement::Kind::kCentroid;
    };
    if (prediction_) {
      const Eigen::Vector3d apart = sphere->p_W - prediction_->p_W;
      const double distance2 = apart.dot((sphere->covariance + prediction_->covariance).ldlt().solve(apart));
      judgement.score /= 1 + distance2;
      if (!(distance2 <= options_.max_prediction_sigmas * options_.max_prediction_sigmas))
        sighting.status = Status::kNotWhereExpected;
    }
    if (lost_at_border(left) || lost_at_border(right) || (only_part && (left.cut_off || right.cut_off))) {
      sighting.status = Status::kCutOff;
    } else if (only_part) {
      sighting.status = Status::kHiddenTooMuch;
    } else if (prior &&
               !agree(free->radius_m, free->radius_sigma_m, prior->radius_m, prior->sigma_m, options_.max_size_ratio)) {
      sighting.status = Status::kOfOtherSize;
    }
    return judgement;
  }

 private:
  bool on_one_line(const Gap& gap, double besides_px = 0) const {
    return std::abs(gap.px) <= options_.max_epipolar_px + kSigmas * gap.sigma_px + besides_px;
  }
  bool same_size(const DiscMeasurement& left, const DiscMeasurement& right, const Triangulation& point) const {
    const double left_m = point.depth_left_m * left.ray().homogeneous().norm();
    const double right_m = point.depth_right_m * right.ray().homogeneous().norm();
    return agree(left.value.z() * left_m, std::sqrt(left.covariance(2, 2)) * left_m, right.value.z() * right_m,
                 std::sqrt(right.covariance(2, 2)) * right_m, options_.max_size_ratio);
  }
  bool fits(const DiscMeasurement& left, const DiscMeasurement& right, double besides_px) const {
    const auto point = triangulate(rig_, {left.ray(), left.ray_covariance()}, {right.ray(), right.ray_covariance()});
    return point && same_size(left, right, *point) &&
           on_one_line(gap_of(rig_, left, right, point->depth_left_m, point->depth_right_m), besides_px);
  }

  const StereoRig& rig_;
  const std::optional<Prediction>& prediction_;
  const SightingOptions& options_;
};

/// How far a pair of this status came: of two pairs the one that came further is the better.
int progress(Status status) {
  switch (status) {
    case Status::kSeen:
      return 6;
    case Status::kHiddenTooMuch:
    case Status::kCutOff:
      return 5;
    case Status::kNotWhereExpected:
      return 4;
    case Status::kOfOtherSize:
      return 3;
    case Status::kLinesOfSightMissed:
      return 2;
    case Status::kNotTheSame:
      return 1;
    default:
      return 0;
  }
}

const DiscMeasurement& largest(std::span<const DiscMeasurement> discs) {
  return *std::ranges::max_element(discs, {}, &DiscMeasurement::area);
}

}  // namespace

const char* description(Sighting::Status status) {
  switch (status) {
    case Status::kSeen:
      return "seen";
    case Status::kWrongImageSize:
      return "an image is not of the size that the calibration is for";
    case Status::kLeftDark:
      return "the left image is black";
    case Status::kRightDark:
      return "the right image is black";
    case Status::kColourEverywhere:
      return "the colour fills most of an image: its class is too wide";
    case Status::kNotInLeft:
      return "not seen in the left image";
    case Status::kNotInRight:
      return "not seen in the right image";
    case Status::kCutOff:
      return "cut off by the border of an image";
    case Status::kNotTheSame:
      return "what the two images show is not the same object";
    case Status::kLinesOfSightMissed:
      return "the two images show discs of one size, but their lines of sight do not meet";
    case Status::kBehindCameras:
      return "the two lines of sight do not meet in front of the cameras";
    case Status::kExchanged:
      return "left and right images seem to be exchanged";
    case Status::kHiddenTooMuch:
      return "too much of it is hidden";
    case Status::kOfOtherSize:
      return "what is seen is not of the size that the ball has";
    case Status::kNotWhereExpected:
      return "something is seen, but not where the object can be by now";
  }
  return "";
}

Sighting sight(const StereoRig& rig, std::span<const DiscMeasurement> left, std::span<const DiscMeasurement> right,
               const std::optional<Prediction>& prediction, const SightingOptions& options) {
  Sighting none;
  if (!left.empty()) none.left_px = largest(left).centre_px;
  if (!right.empty()) none.right_px = largest(right).centre_px;
  none.status = left.empty() ? Status::kNotInLeft : Status::kNotInRight;
  if (left.empty() || right.empty()) return none;

  const Judge judge(rig, prediction, options);
  std::optional<Judgement> best;
  for (size_t i = 0; i < left.size(); ++i) {
    for (size_t j = 0; j < right.size(); ++j) {
      Judgement judgement = judge(left[i], right[j]);
      judgement.sighting.left = static_cast<int>(i);
      judgement.sighting.right = static_cast<int>(j);
      const int came = progress(judgement.sighting.status), best_came = best ? progress(best->sighting.status) : -1;
      if (came > best_came || (came == best_came && judgement.score > best->score)) best = judgement;
    }
  }
  return best->sighting;
}

}  // namespace multireach::vision
