#include "vision/tag_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "vision/stereo/triangulate.hpp"
#include "vision/track/exposure_skew.hpp"
#include "vision/track/search_window.hpp"

namespace multireach::vision {
namespace {

constexpr double kWindowSides = 1.1;  // of the tag, around its predicted centre: half its diagonal, and a white margin
constexpr double kWindowMargin = 10;  // pixels
constexpr double kNearest = 0.1;     // share of the centre's distance: a part of the tag that is nearer fills the image
constexpr double kWorthwhile = 0.5;  // above this share of the image, the whole image is searched instead
// Above this chi2 the images contradict each other, or the size: far beyond what noise gives, because the noise of
// edges is known to some factor only.
constexpr double kChi2PerDegree = 4, kChi2 = 30;

// Tolerance for the tag's centre in an image that the pose does not use: pixels, plus a share of the tag's side, plus
// kSigmas of the pose.
constexpr double kCornerPx = 2, kCornerSides = 0.1, kSigmas = 4;

constexpr const char* kContradiction =
    "the two images contradict each other or the tag's size: check size_m and the calibration";
constexpr const char* kAmbiguous = "seen, but two orientations fit the images: the tag is too small or too far away";

const TagOptions& checked(const TagOptions& options) {
  const auto require = [](bool sensible, const char* sentence) {
    if (!sensible) throw std::invalid_argument(sentence);
  };
  require_usable(options.rig);
  require(options.id >= 0 && options.id < kTagIds, "a tag's id must be from 0 to 586");
  require(options.size.side_m > 0, "a tag's size must be positive");
  require(options.size.tolerance_m >= 0 && options.sigma_px >= 0, "a tag's tolerances must not be negative");
  return options;
}

const char* sentence_for(EdgeFault fault, Side side) {
  const bool left = side == Side::kLeft;
  switch (fault) {
    case EdgeFault::kCutOff:
      return left ? "the left image cuts off the tag or its white margin"
                  : "the right image cuts off the tag or its white margin";
    case EdgeFault::kTooSmall:
      return left ? "the tag is too small in the left image" : "the tag is too small in the right image";
    case EdgeFault::kLowContrast:
      return left ? "black and white of the tag are too similar in the left image"
                  : "black and white of the tag are too similar in the right image";
    case EdgeFault::kBlurred:
      return left ? "the tag is blurred in the left image" : "the tag is blurred in the right image";
    case EdgeFault::kNotStraight:
      return left ? "the tag's border is not straight in the left image: it is covered or not flat"
                  : "the tag's border is not straight in the right image: it is covered or not flat";
    case EdgeFault::kNone:
      break;
  }
  return "no pose of the tag explains its corners";
}

/// Whether an image that was not used for a pose shows the tag where the pose puts it.
/// `moved_m`: standard deviation of the tag's motion between the two images.
bool agrees(const TagPose& pose, double side_m, const TagObservation& observation, double moved_m) {
  Eigen::Vector2d expected(0, 0), found(0, 0);
  Eigen::Matrix<double, 2, kTagUnknowns> J = Eigen::Matrix<double, 2, kTagUnknowns>::Zero();
  for (int k = 0; k < 4; ++k) {
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, kTagUnknowns> of_corner;
    if (!project(observation.camera, pose.tag, side_m * tag_corner(k), pixel, of_corner)) return false;
    expected += pixel / 4;
    found += observation.corners[static_cast<size_t>(k)] / 4;
    J += of_corner / 4;
  }
  const auto by_pose = J.leftCols<6>();
  const double side_px = (observation.corners[1] - observation.corners[0]).norm(),
               corner = kCornerPx + kCornerSides * side_px;
  Eigen::Matrix<double, 6, 6> covariance = pose.covariance;
  covariance.topLeftCorner<3, 3>().diagonal().array() += moved_m * moved_m;
  const Eigen::Matrix2d total =
      kSigmas * kSigmas * by_pose * covariance * by_pose.transpose() + corner * corner * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d apart = found - expected;
  return apart.dot(total.ldlt().solve(apart)) <= 1;
}

/// Why neither image shows the tag once.
const char* missing(const std::array<TagView, 2>& views) {
  for (const TagView& view : views) {
    if (view.matches.size() > 1) return "two tags with this id are seen";
  }
  for (const TagView& view : views) {
    if (view.others) return "a tag is seen, but with another id";
  }
  return "no tag is seen: it is outside both images, covered, blurred, or too small";
}

}  // namespace

TagTracker::TagTracker(const TagOptions& options) : options_(checked(options)), track_(options.track) {}

void TagTracker::restart() {
  track_ = TargetTrack(options_.track);
  R_WT_.reset();
}

void TagTracker::expire(int64_t utime) {
  track_.expire(utime);
  if (track_.status() == TargetTrack::Status::kLost) R_WT_.reset();
}

cv::Rect TagTracker::whole_image(Side side) const {
  const CameraModel& camera = options_.rig.camera(side);
  return {0, 0, camera.width, camera.height};
}

cv::Rect TagTracker::window(Side side, int64_t utime) const {
  const cv::Rect whole = whole_image(side);
  const auto predicted = track_.predicted(utime);
  if (!predicted) return whole;
  const StereoRig& rig = options_.rig;
  const CameraModel& camera = rig.camera(side);
  Eigen::Vector3d p = rig.X_WL.inverse() * predicted->position;
  if (side == Side::kRight) p = rig.X_RL * p;
  const double reach_m = kWindowSides * options_.size.side_m;
  const auto found = search_window(
      camera, p, predicted->covariance,
      {.nearer_m = reach_m, .around_m = reach_m, .margin_px = kWindowMargin, .least_z_m = kNearest * p.z()});
  if (!found) return whole;
  const cv::Rect window = *found & whole;
  return window.empty() || window.area() > kWorthwhile * whole.area() ? whole : window;
}

/// How far the tag moves, in W, from the pair's time to an image's.
Eigen::Vector3d TagTracker::motion_of(const PairTimes& times, Side side) const {
  if (track_.status() == TargetTrack::Status::kLost) return Eigen::Vector3d::Zero();
  return track_.velocity() * offset_s(side == Side::kLeft ? times.left : times.right, times.pair);
}

/// The images that show the tag; none where one shows it twice. A camera whose image is earlier or later than the pair
/// is shifted by the opposite of the tag's motion, so that all show it at the time of the pair.
std::vector<TagObservation> TagTracker::observations_of(const PairTimes& times, const std::array<TagView, 2>& views,
                                                        std::vector<Side>& sides) const {
  std::vector<TagObservation> observations;
  // Where one image shows two tags with this id, the one in the other image may be either.
  if (std::ranges::any_of(views, [](const TagView& view) { return view.matches.size() > 1; })) return observations;
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const TagView& view = views[index(side)];
    if (view.matches.empty()) continue;
    TagCamera camera{options_.rig.left, Eigen::Isometry3d::Identity()};
    if (side == Side::kRight) camera = {options_.rig.right, options_.rig.X_RL};
    const Eigen::Vector3d moved_L = options_.rig.X_WL.linear().transpose() * motion_of(times, side);
    camera.X_CL.translation() += camera.X_CL.linear() * moved_L;
    observations.push_back({camera, view.bgr, view.window, view.matches.front().corners});
    sides.push_back(side);
  }
  return observations;
}

TagMatch TagTracker::match(const PairTimes& times, const std::array<TagView, 2>& views) const {
  TagMatch match;
  std::vector<Side> sides;
  std::vector<TagObservation> observations = observations_of(times, views, sides);
  match.reason = missing(views);
  std::vector<TagObservation> left_out;
  // An image in which the tag cannot be measured, at the border of its image for example, leaves the other one.
  while (!observations.empty()) {
    TagFit fit = fit_tag(observations, options_.size, options_.sigma_px);
    if (fit.best) {
      match.pose = std::move(fit.best);
      if (fit.other) match.other_position_L = fit.other->tag.X_LT.translation();
      break;
    }
    match.reason = sentence_for(fit.fault, sides[fit.faulty]);
    if (fit.fault != EdgeFault::kCutOff && fit.fault != EdgeFault::kTooSmall) return match;
    left_out.push_back(observations[fit.faulty]);
    observations.erase(observations.begin() + static_cast<std::ptrdiff_t>(fit.faulty));
    sides.erase(sides.begin() + static_cast<std::ptrdiff_t>(fit.faulty));
  }
  if (!match.pose) return match;
  // Where the images contradict each other, the pose by both may be outside of one, which only seems to be cut off.
  const bool lost = track_.status() == TargetTrack::Status::kLost;
  const Eigen::Matrix3d speed2 = lost ? unknown_velocity_covariance() : track_.velocity_covariance();
  const double speed = std::sqrt(speed2.trace() / 3);
  const double moved_m = speed * std::abs(offset_s(times.left, times.pair) - offset_s(times.right, times.pair));
  if (!std::ranges::all_of(left_out, [&](const TagObservation& observation) {
        return agrees(*match.pose, options_.size.side_m, observation, moved_m);
      })) {
    match.pose.reset();
    match.reason = kContradiction;
    return match;
  }
  for (size_t k = 0; k < sides.size(); ++k) {
    match.used[index(sides[k])] = true;
    match.centre_px[index(sides[k])] = match.pose->measured_centre_px[k];
  }
  if (sides.size() == 2) {
    const auto ray = [&](size_t k) {
      const CameraModel& camera = observations[k].camera.model;
      return RayMeasurement{camera.ray(match.centre_px[k]), ray_covariance(camera, 1)};
    };
    StereoRig rig = options_.rig;
    rig.X_RL = observations[1].camera.X_CL * observations[0].camera.X_CL.inverse();
    if (const auto point = triangulate(rig, ray(0), ray(1))) match.epipolar_error_px = point->epipolar_error_px;
  }
  if (match.pose->chi2 > kChi2PerDegree * match.pose->degrees_of_freedom + kChi2) {
    match.pose.reset();
    match.reason =
        sides.size() == 2
            ? kContradiction
            : "the tag's sides contradict each other: it is not flat, or the camera's lens is not calibrated";
  }
  return match;
}

TagReport TagTracker::report(int64_t utime, TargetTrack::Status status, const char* reason) const {
  TagReport report;
  report.status = status;
  const bool before = status != TargetTrack::Status::kLost && utime < track_.utime();
  report.estimate = before ? track_.estimate_before(utime) : track_.estimate();
  report.velocity = track_.velocity();
  report.velocity_covariance = track_.velocity_covariance();
  report.last_seen_utime = track_.last_seen_utime();
  report.reason = reason;
  if (status != TargetTrack::Status::kLost) report.R_WT = R_WT_;
  return report;
}

TagReport TagTracker::update_unseen(int64_t utime, const char* reason) {
  if (track_.begun() && utime <= track_.utime()) return report(utime, track_.unseen_status(utime), reason);
  track_.update(utime, std::nullopt);
  if (track_.status() == TargetTrack::Status::kLost) R_WT_.reset();
  return report(utime, track_.unseen_status(utime), reason);
}

TagReport TagTracker::update(const PairTimes& times, const TagMatch& match) {
  if (!match.pose) return update_unseen(times.pair, match.reason);
  const Eigen::Isometry3d& X_WL = options_.rig.X_WL;
  const Eigen::Matrix3d R_WL = X_WL.linear();
  const Eigen::Isometry3d X_WT = X_WL * match.pose->tag.X_LT;
  PositionEstimate estimate{X_WT.translation(), R_WL * match.pose->covariance.topLeftCorner<3, 3>() * R_WL.transpose()};
  if (match.other_position_L) {
    const Eigen::Vector3d apart = X_WL * *match.other_position_L - estimate.position;
    estimate.covariance += 0.5 * apart * apart.transpose();
  }
  // The motion between the exposures and the pair's time is known as well as the speed is.
  double largest_offset_s = 0;
  for (const Side side : {Side::kLeft, Side::kRight}) {
    if (match.used[index(side)])
      largest_offset_s =
          std::max(largest_offset_s, std::abs(offset_s(side == Side::kLeft ? times.left : times.right, times.pair)));
  }
  const bool lost = track_.status() == TargetTrack::Status::kLost;
  const Eigen::Matrix3d speed2 = lost ? unknown_velocity_covariance() : track_.velocity_covariance();
  estimate.covariance += speed2 * largest_offset_s * largest_offset_s;
  if (match.used[0] && match.used[1]) {
    const double later = offset_s(times.right, times.pair) - offset_s(times.left, times.pair);
    estimate.covariance += covariance_of_skew(options_.rig, estimate.position, speed2, later);
  }
  const int64_t before = track_.utime();
  if (!track_.update(times.pair, estimate)) {
    const bool past = track_.utime() == before && times.pair <= before;
    if (track_.status() == TargetTrack::Status::kLost) R_WT_.reset();
    return report(times.pair, track_.unseen_status(times.pair),
                  past ? kNotNewer : "the tag is seen, but not where it is expected");
  }
  R_WT_.reset();
  if (!match.other_position_L) R_WT_ = Eigen::Quaterniond(X_WT.linear()).normalized();
  TagReport tracked = report(times.pair, TargetTrack::Status::kTracked, match.other_position_L ? kAmbiguous : "seen");
  tracked.estimate = estimate;
  tracked.orientation_covariance = R_WL * match.pose->covariance.bottomRightCorner<3, 3>() * R_WL.transpose();
  return tracked;
}

std::vector<double> TagTracker::serialize(int64_t utime) const {
  std::vector<double> state = track_.serialize();
  state.push_back(static_cast<double>(track_.utime() - utime));
  const Eigen::Vector4d wxyz =
      R_WT_ ? Eigen::Vector4d(R_WT_->w(), R_WT_->x(), R_WT_->y(), R_WT_->z()) : Eigen::Vector4d::Zero();
  state.insert(state.end(), wxyz.data(), wxyz.data() + 4);
  return state;
}

bool TagTracker::deserialize(int64_t utime, std::span<const double> state) {
  constexpr size_t kOwn = 5;
  constexpr double kLongest = 9e15;  // us; a double represents integers up to here exactly
  if (state.size() < kOwn) return false;
  const auto own = state.last(kOwn);
  if (!(own[0] >= -kLongest && own[0] <= kLongest && own[0] == std::floor(own[0]))) return false;
  const Eigen::Map<const Eigen::Vector4d> wxyz(&own[1]);
  const bool known = !wxyz.isZero(0);
  if (known && !(std::abs(wxyz.norm() - 1) < 1e-9)) return false;
  if (!track_.deserialize(utime + static_cast<int64_t>(own[0]), state.first(state.size() - kOwn))) return false;
  R_WT_.reset();
  if (known) R_WT_ = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  return true;
}

}  // namespace multireach::vision
