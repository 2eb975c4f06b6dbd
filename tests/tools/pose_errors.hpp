#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>
#include <optional>
#include <vector>

#include "kinematics/chain.hpp"
#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"

namespace multireach {

/// How far the hand of a recorded robot is from the true pose of the target, when the target has rested for a while.
struct PoseError {
  double at_s = 0;  ///< since the first TARGET_TRUTH
  double position_m = 0, angle_rad = 0;
};

/// The error at the end of each rest of at least `rest_s` seconds, which a motion, or the end of the log, ends: of the
/// last ROBOT_STATE before, which must be at most 0.1 s older by the time of receipt.
inline std::vector<PoseError> pose_errors(const std::string& path, const Chain& chain, double rest_s) {
  LogReader log(path);
  std::vector<PoseError> errors;
  std::optional<target_t> resting;
  std::optional<robot_state_t> robot;
  int64_t first = -1, since = 0, robot_at = 0, now = 0;
  const auto take = [&] {
    if (!resting || !robot || static_cast<double>(now - since) < rest_s * 1e6 || now - robot_at > 100000) return;
    const auto theta = from_fields(chain, robot->joint_name, robot->joint_position);
    if (!theta) return;
    const Eigen::Isometry3d X_WT = chain.pose(*theta);
    const double* q = resting->orientation_wxyz;
    const Eigen::Matrix3d R_WT = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
    errors.push_back({1e-6 * static_cast<double>(now - first),
                      (X_WT.translation() - Eigen::Map<const Eigen::Vector3d>(resting->position_m)).norm(),
                      Eigen::AngleAxisd(R_WT.transpose() * X_WT.linear()).angle()});
  };
  while (const auto event = log.next()) {
    if (event->channel == channel::kRobotState) {
      robot = decode<robot_state_t>(event->data);
      robot_at = event->utime;
    }
    if (event->channel != channel::kTargetTruth) continue;
    const auto truth = decode<target_t>(event->data);
    if (!truth) continue;
    now = event->utime;
    if (first < 0) first = now;
    const bool same = resting && std::ranges::equal(truth->position_m, resting->position_m);
    if (same) continue;
    take();
    resting = truth;
    since = now;
  }
  take();
  return errors;
}

}  // namespace multireach
