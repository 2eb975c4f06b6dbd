#include "vision/stereo_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace multireach::vision {
namespace {

constexpr int kMostBlobs = 6;          // of one image, that are measured
constexpr double kFilled = 0.5;        // share of an image's pixels in the class, beyond which the class is too wide
constexpr double kUnknownSpeed = 0.5;  // m/s, standard deviation, of a target that was not tracked
constexpr int64_t kFarApart = 200000;  // us: an image of such another time than its pair's has none of its own
constexpr double kWindowSigmas = 2.5;  // of where the target is expected; beyond, the whole image is looked at
constexpr double kWindowRadii = 2;     // around it, so that its background is seen too
constexpr double kWindowMargin = 8;    // pixels
constexpr double kWorthwhile = 0.5;    // a window of more than this share of the image is no gain
constexpr double kDimmest = 10;        // grey levels: no pixel of a black image is brighter

const TrackerOptions& checked(const TrackerOptions& options) {
  const auto require = [](bool sensible, const char* sentence) {
    if (!sensible) throw std::invalid_argument(sentence);
  };
  for (const CameraModel* camera : {&options.rig.left, &options.rig.right}) {
    require(camera->width > 0 && camera->height > 0, "a camera's image size must be positive");
    require(camera->fx > 0 && camera->fy > 0, "a camera's focal lengths must be positive");
  }
  require(options.rig.baseline_m() > 1e-6, "the two cameras are at the same place: there is no baseline");
  // The right camera's place in the left one's frame.
  require(options.rig.X_RL.inverse().translation().x() > 0,
          "the right camera is to the left of the left one: the images are swapped, or the baseline's sign is wrong");
  const SightingOptions& sighting = options.sighting;
  require(sighting.radius_m >= 0 && sighting.radius_tolerance_m >= 0 && options.sigma_px >= 0 &&
              options.min_area_px > 0 && sighting.max_epipolar_px > 0 && sighting.max_size_ratio > 1 &&
              sighting.max_hidden > 0 && sighting.max_prediction_sigmas > 0,
          "the tracker's sizes and thresholds must be positive");
  return options;
}

/// Whether no pixel of every eighth in both directions is brighter than that of a covered or dead camera.
bool is_dark(const cv::Mat& bgr) {
  constexpr int kStep = 8;
  for (int row = kStep / 2; row < bgr.rows; row += kStep) {
    const auto* pixels = bgr.ptr<cv::Vec3b>(row);
    for (int column = kStep / 2; column < bgr.cols; column += kStep) {
      const cv::Vec3b& p = pixels[column];
      if (p[0] > kDimmest || p[1] > kDimmest || p[2] > kDimmest) return false;
    }
  }
  return true;
}

/// Time of an image relative to its pair's, s; 0 where the image has no sensible time of its own.
double offset_s(int64_t image, int64_t pair) {
  const int64_t offset = image - pair;
  return std::abs(offset) <= kFarApart ? static_cast<double>(offset) * 1e-6 : 0;
}

}  // namespace

StereoTracker::StereoTracker(const TrackerOptions& options)
    : options_(checked(options)), eyes_{eye(options, Side::kLeft), eye(options, Side::kRight)}, track_(options.track) {}

StereoTracker::Eye StereoTracker::eye(const TrackerOptions& options, Side side) {
  const bool left = side == Side::kLeft;
  const bool sphere = options.sighting.radius_m > 0;
  return {left ? options.rig.left : options.rig.right, options.colour[left ? 0 : 1],
          sphere ? DiscMeasurer::kOfASphere : DiscMeasurer::kOfAnything};
}

bool StereoTracker::begin(int64_t utime) {
  if (!track_.begins_anew(utime)) return false;
  track_ = TargetTrack(options_.track);
  radius_m_ = 0;
  for (Eye& eye : eyes_) eye.shift = {};
  return true;
}

cv::Rect StereoTracker::whole_image(Side side) const {
  const CameraModel& camera = side == Side::kLeft ? options_.rig.left : options_.rig.right;
  return {0, 0, camera.width, camera.height};
}

cv::Rect StereoTracker::window(Side side, int64_t utime) const {
  const cv::Rect whole = whole_image(side);
  const auto expected = track_.expected(utime);
  if (!expected || radius_m_ <= 0) return whole;
  const StereoRig& rig = options_.rig;
  const bool left = side == Side::kLeft;
  const CameraModel& camera = left ? rig.left : rig.right;
  Eigen::Vector3d p = rig.X_WL.inverse() * expected->position;
  if (!left) p = rig.X_RL * p;
  // At least the standard deviation in any direction: a norm of the covariance.
  const double sigma_m = std::sqrt(expected->covariance.cwiseAbs().rowwise().sum().maxCoeff());
  const double near = p.z() - radius_m_ - kWindowSigmas * sigma_m;
  if (!(near > radius_m_)) return whole;
  const double half =
      std::max(camera.fx, camera.fy) * (kWindowRadii * radius_m_ + kWindowSigmas * sigma_m) / near + kWindowMargin;
  const Eigen::Vector2d centre = camera.project(p);
  if (!(centre.cwiseAbs().maxCoeff() < 1e5 && half < 1e5)) return whole;
  const auto first = [&](double at) { return static_cast<int>(std::floor(at - half)); };
  const int size = static_cast<int>(std::ceil(2 * half)) + 1;
  const cv::Rect window = cv::Rect(first(centre.x()), first(centre.y()), size, size) & whole;
  return window.empty() || window.area() > kWorthwhile * whole.area() ? whole : window;
}

View StereoTracker::look(Side side, const cv::Mat& bgr, const cv::Rect& window) {
  Eye& eye = eyes_[static_cast<size_t>(index(side))];
  const cv::Rect whole = whole_image(side);
  View view;
  view.fits = bgr.type() == CV_8UC3 && bgr.size() == whole.size();
  if (!view.fits) return view;
  view.window = window;
  view.bgr = bgr;
  const Found found = eye.finder.find(bgr, window, eye.model.members(eye.shift),
                                      {.min_area = options_.min_area_px, .most = kMostBlobs});
  view.filled = found.crowded || static_cast<double>(found.members) > kFilled * whole.area();
  if (view.filled) return view;
  view.blobs.assign(found.blobs.begin(), found.blobs.end());
  const Eigen::Matrix2d besides =
      ray_covariance(side == Side::kLeft ? options_.rig.left : options_.rig.right, options_.sigma_px);
  for (const Blob& blob : view.blobs) {
    view.discs.push_back(eye.measurer.measure(bgr, blob));
    view.discs.back().covariance.topLeftCorner<2, 2>() += besides;
  }
  view.dark = view.blobs.empty() && window == whole && is_dark(bgr);
  return view;
}

/// The rig as it is for a target that moves between the two exposures: the right camera sees it where it will be or
/// was, which is as if the camera were moved the other way.
StereoRig StereoTracker::rig_at(const PairTimes& times) const {
  StereoRig rig = options_.rig;
  if (track_.status() == TargetTrack::Status::kLost) return rig;
  const double later = offset_s(times.right, times.pair) - offset_s(times.left, times.pair);
  rig.X_RL.translation() += rig.X_RL.linear() * (rig.X_WL.linear().transpose() * (track_.velocity() * later));
  return rig;
}

Sighting StereoTracker::sight(const PairTimes& times, const View& left, const View& right) const {
  using Status = Sighting::Status;
  Sighting sighting;
  const auto failed = [&sighting](Status status) {
    sighting.status = status;
    return sighting;
  };
  if (!left.fits || !right.fits) return failed(Status::kWrongImageSize);
  if (left.filled || right.filled) return failed(Status::kColourEverywhere);
  if (left.dark) return failed(Status::kLeftDark);
  if (right.dark) return failed(Status::kRightDark);
  std::optional<Prediction> prediction;
  if (const auto expected = track_.expected(times.pair)) {
    // The sighting is of the time of the left image.
    prediction = {expected->position + track_.velocity() * offset_s(times.left, times.pair), expected->covariance};
  }
  sighting = vision::sight(rig_at(times), left.discs, right.discs, prediction, options_.sighting);
  const bool apart = sighting.status == Status::kBehindCameras || sighting.status == Status::kNotTheSame ||
                     sighting.status == Status::kLinesOfSightMissed;
  if (apart && sighting.fits_exchanged) sighting.status = Status::kExchanged;
  return sighting;
}

bool StereoTracker::enough(const Sighting& sighting, const View& left, const View& right) const {
  if (sighting.status != Sighting::Status::kSeen) return false;
  // Edges are measured in pixels beyond the blob's.
  constexpr int kRead = 10;
  const auto whole = [](const cv::Rect& box, const cv::Rect& window, const cv::Rect& image) {
    return (box.x - kRead >= window.x || window.x == 0) && (box.y - kRead >= window.y || window.y == 0) &&
           (box.br().x + kRead <= window.br().x || window.br().x == image.width) &&
           (box.br().y + kRead <= window.br().y || window.br().y == image.height);
  };
  return whole(left.blobs[static_cast<size_t>(sighting.left)].box, left.window, whole_image(Side::kLeft)) &&
         whole(right.blobs[static_cast<size_t>(sighting.right)].box, right.window, whole_image(Side::kRight));
}

/// The track's status after a pair that was not taken for the target: a pair that is not later changes nothing in it.
TargetTrack::Status StereoTracker::unseen_status() const {
  return track_.status() == TargetTrack::Status::kTracked ? TargetTrack::Status::kCoasting : track_.status();
}

/// A sighting as a place at the time of the pair, with what is not known of the motion between the exposures.
PlaceEstimate StereoTracker::place_at_pair(const PairTimes& times, const Sighting& sighting) const {
  PlaceEstimate place{sighting.point.p_W, sighting.point.covariance};
  const bool lost = track_.status() == TargetTrack::Status::kLost;
  const double left = offset_s(times.left, times.pair), later = offset_s(times.right, times.pair) - left;
  if (!lost) place.position -= track_.velocity() * left;
  const Eigen::Matrix3d speed2 =
      lost ? (Eigen::Matrix3d::Identity() * kUnknownSpeed * kUnknownSpeed).eval() : track_.velocity_covariance();
  place.covariance += speed2 * left * left;
  // A motion e across the line of sight between the exposures is taken for one of e Z / B along it.
  const Eigen::Vector3d line = options_.rig.X_WL.linear() * (options_.rig.X_WL.inverse() * sighting.point.p_W);
  const double ratio = line.norm() / options_.rig.baseline_m();
  const Eigen::Vector3d along = line.normalized();
  place.covariance += along * along.transpose() * (speed2.trace() / 3 * later * later * ratio * ratio);
  return place;
}

TargetReport StereoTracker::report(TargetTrack::Status status, const char* reason) const {
  return {.status = status,
          .place = track_.place(),
          .velocity = track_.velocity(),
          .velocity_covariance = track_.velocity_covariance(),
          .seen_utime = track_.seen_utime(),
          .reason = reason};
}

TargetReport StereoTracker::take_unseen(int64_t utime, const char* reason) {
  track_.take(utime, std::nullopt);
  for (Eye& eye : eyes_) eye.shift = relaxed(eye.shift);
  return report(unseen_status(), reason);
}

TargetReport StereoTracker::take(const PairTimes& times, const Sighting& sighting, const View& left,
                                 const View& right) {
  using Status = Sighting::Status;
  // One that is elsewhere may have jumped there: the track believes it when it stays.
  const bool seen = sighting.status == Status::kSeen || sighting.status == Status::kNotWhereExpected;
  // What is seen of it tells a little; enough to follow it, not to find it.
  const bool partly = (sighting.status == Status::kHiddenTooMuch || sighting.status == Status::kCutOff) &&
                      sighting.left >= 0 && sighting.right >= 0 && track_.status() != TargetTrack::Status::kLost;
  if (!seen && !partly) return take_unseen(times.pair, description(sighting.status));
  const int64_t before = track_.utime();
  const PlaceEstimate place = place_at_pair(times, sighting);
  if (!track_.take(times.pair, place, seen)) {
    const bool past = track_.utime() == before && times.pair <= before;
    return report(unseen_status(), past ? "seen, but of a time that is past" : description(Status::kNotWhereExpected));
  }
  if (partly) return report(TargetTrack::Status::kCoasting, description(sighting.status));
  const Eigen::Vector3d p_L = options_.rig.X_WL.inverse() * sighting.point.p_W;
  radius_m_ = options_.sighting.radius_m > 0 ? options_.sighting.radius_m
                                             : left.discs[static_cast<size_t>(sighting.left)].value.z() * p_L.norm();
  if (options_.adapt_colour) {
    // What is no sphere is less surely all of it the object.
    const double quality = sighting.both_by_edges ? 1 - sighting.hidden : 0.5;
    adapt(Side::kLeft, left, sighting.left, quality);
    adapt(Side::kRight, right, sighting.right, quality);
  }
  TargetReport said = report(TargetTrack::Status::kTracked, description(Status::kSeen));
  said.place = place;
  return said;
}

void StereoTracker::adapt(Side side, const View& view, int chosen, double quality) {
  Eye& eye = eyes_[static_cast<size_t>(index(side))];
  const LightSample sample = eye.model.sample(eye.shift, view.bgr, view.blobs[static_cast<size_t>(chosen)]);
  eye.shift = adapted(eye.shift, sample, quality);
}

std::vector<double> StereoTracker::memory(int64_t utime) const {
  std::vector<double> memory = track_.memory();
  memory.push_back(static_cast<double>(track_.utime() - utime));
  memory.push_back(radius_m_);
  for (const Eye& eye : eyes_) memory.insert(memory.end(), {eye.shift.red, eye.shift.blue});
  return memory;
}

bool StereoTracker::restore(int64_t utime, std::span<const double> memory) {
  constexpr size_t kOwn = 6;
  constexpr double kLongest = 9e15;  // us, as exact as a double is
  if (memory.size() < kOwn) return false;
  const auto own = memory.last(kOwn);
  if (!(own[0] >= -kLongest && own[0] <= kLongest && own[0] == std::floor(own[0]))) return false;
  if (!(own[1] >= 0 && own[1] < 1e6)) return false;
  for (const double gain : own.last(4)) {
    if (!(gain >= kSmallestGain && gain <= kLargestGain)) return false;
  }
  if (!track_.restore(utime + static_cast<int64_t>(own[0]), memory.first(memory.size() - kOwn))) return false;
  radius_m_ = own[1];
  eyes_[0].shift = {own[2], own[3]};
  eyes_[1].shift = {own[4], own[5]};
  return true;
}

Sighting StereoTracker::find(const cv::Mat& left_bgr, const cv::Mat& right_bgr) {
  const View left = look(Side::kLeft, left_bgr, whole_image(Side::kLeft));
  const View right = look(Side::kRight, right_bgr, whole_image(Side::kRight));
  return sight({}, left, right);
}

}  // namespace multireach::vision
