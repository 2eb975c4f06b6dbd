#pragma once

#include <Eigen/Cholesky>
#include <array>

#include "imaging/rig_errors.hpp"
#include "imaging/stereo_rig.hpp"
#include "vision/track/target_report.hpp"

namespace multireach::vision {

/// The covariance of a position as it is reported: that of its measurement, and what the errors of the calibration
/// cause. Trackers work without the latter: these errors are the same in every image, so a filter or a gate does not
/// meet them as noise.
inline Eigen::Matrix3d reported_covariance(const StereoRig& rig, const PositionEstimate& measured) {
  if (!rig.errors.known()) return measured.covariance;
  return measured.covariance + covariance_by_rig_errors(rig, measured.position);
}

/// What reported_covariance() made of a measurement's covariance, reversed, for callers that average positions: the
/// calibration's error is common to all of them and is no noise. Returns the reported covariance if the difference is
/// not positive definite, as that of another calibration.
inline Eigen::Matrix3d measured_covariance(const StereoRig& rig, const PositionEstimate& reported) {
  if (!rig.errors.known()) return reported.covariance;
  const Eigen::Matrix3d measured = reported.covariance - covariance_by_rig_errors(rig, reported.position);
  return measured.llt().info() == Eigen::Success ? measured : reported.covariance;
}

/// Completes the covariance of a report; that of a lost target means nothing.
inline void add_rig_errors(const StereoRig& rig, TargetReport& report) {
  if (report.status != TargetTrack::Status::kLost)
    report.estimate.covariance = reported_covariance(rig, report.estimate);
}

/// The same for an object of known size that is measured in the images `used`: one alone tells its position as well.
inline void add_rig_errors(const StereoRig& rig, const std::array<bool, 2>& used, TargetReport& report) {
  if (used[0] == used[1]) {
    add_rig_errors(rig, report);
  } else if (rig.errors.known() && report.status != TargetTrack::Status::kLost) {
    const Side side = used[0] ? Side::kLeft : Side::kRight;
    report.estimate.covariance += covariance_by_rig_errors(rig, side, report.estimate.position);
  }
}

}  // namespace multireach::vision
