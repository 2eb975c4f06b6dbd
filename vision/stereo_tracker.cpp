#include "vision/stereo_tracker.hpp"

#include <stdexcept>

namespace multireach::vision {
namespace {

const TrackerOptions& checked(const TrackerOptions& options) {
  const auto require = [](bool sensible, const char* sentence) {
    if (!sensible) throw std::invalid_argument(sentence);
  };
  require(!options.colour.references.empty(), "the colour class needs at least one reference colour");
  for (const CameraModel* camera : {&options.rig.left, &options.rig.right}) {
    require(camera->width > 0 && camera->height > 0, "a camera's image size must be positive");
    require(camera->fx > 0 && camera->fy > 0, "a camera's focal lengths must be positive");
  }
  require(options.rig.baseline_m() > 1e-6, "the two cameras are at the same place: there is no baseline");
  // The right camera's place in the left one's frame.
  require(options.rig.X_RL.inverse().translation().x() > 0,
          "the right camera is to the left of the left one: the images are swapped, or the baseline's sign is wrong");
  require(options.ball_radius_m >= 0 && options.min_area_px > 0 && options.sigma_px > 0 && options.max_epipolar_px > 0,
          "the tracker's sizes and thresholds must be positive");
  return options;
}

}  // namespace

StereoTracker::StereoTracker(const TrackerOptions& options) : options_(checked(options)), table_(options.colour) {}

std::optional<Triangulation> StereoTracker::locate(const OutlinedBlob& left, const OutlinedBlob& right) const {
  const StereoRig& rig = options_.rig;
  // The lens distortion is taken from the outline before the centroid: the two do not commute for a large blob.
  const auto left_centroid = polygon_centroid(rig.left.rays(left.outline));
  const auto right_centroid = polygon_centroid(rig.right.rays(right.outline));
  if (!left_centroid || !right_centroid) return std::nullopt;
  const Eigen::Vector2d left_ray = *left_centroid, right_ray = *right_centroid;
  const Eigen::Matrix2d left_covariance = ray_covariance(rig.left, options_.sigma_px),
                        right_covariance = ray_covariance(rig.right, options_.sigma_px);
  auto point = triangulate(rig, {left_ray, left_covariance}, {right_ray, right_covariance});
  // The outline of a sphere at (X, Y, Z) is an ellipse centred on (X, Y) Z / (Z^2 - r^2), not on (X, Y) / Z.
  const double r2 = options_.ball_radius_m * options_.ball_radius_m;
  constexpr int kRounds = 3;  // each gains a factor r^2 / Z^2
  for (int round = 0; round < kRounds && r2 > 0 && point; ++round) {
    const double zl = point->depth_left_m, zr = point->depth_right_m;
    if (zl * zl <= 2 * r2 || zr * zr <= 2 * r2) return std::nullopt;
    point = triangulate(rig, {left_ray * (1 - r2 / (zl * zl)), left_covariance},
                        {right_ray * (1 - r2 / (zr * zr)), right_covariance});
  }
  return point;
}

View StereoTracker::look(Side side, const cv::Mat& bgr) {
  const CameraModel& camera = side == Side::kLeft ? options_.rig.left : options_.rig.right;
  View view;
  view.fits = bgr.type() == CV_8UC3 && bgr.cols == camera.width && bgr.rows == camera.height;
  if (!view.fits) return view;
  cv::Mat& mask = side == Side::kLeft ? left_mask_ : right_mask_;
  table_.classify(bgr, mask);
  view.blob = largest_blob(mask, options_.min_area_px);
  return view;
}

Sighting StereoTracker::find(const View& left, const View& right) const {
  using Status = Sighting::Status;
  Sighting sighting;
  const auto failed = [&sighting](Status status) {
    sighting.status = status;
    return sighting;
  };
  if (!left.fits || !right.fits) return failed(Status::kWrongImageSize);
  if (!left.blob) return failed(Status::kNotInLeft);
  sighting.left_px = left.blob->centroid;
  if (!right.blob) return failed(Status::kNotInRight);
  sighting.right_px = right.blob->centroid;
  if (left.blob->cut_off || right.blob->cut_off) return failed(Status::kCutOff);
  const auto point = locate(*left.blob, *right.blob);
  if (!point) return failed(Status::kBehindCameras);
  static_cast<Triangulation&>(sighting.point) = *point;
  sighting.status = point->epipolar_error_px > options_.max_epipolar_px ? Status::kNotTheSame : Status::kSeen;
  return sighting;
}

}  // namespace multireach::vision
