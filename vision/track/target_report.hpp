#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "vision/track/target_track.hpp"

namespace multireach::vision {

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

}  // namespace multireach::vision
