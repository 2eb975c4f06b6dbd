#pragma once

#include <optional>
#include <string>

#include "controller/reach_controller.hpp"
#include "studies/figures/motion.hpp"

namespace multireach {

/// A force (N, in the world frame) on a link of the arm, from `from_s` to `until_s`.
struct TimedPush {
  std::string link;
  Eigen::Vector3d force_n;
  double from_s = 0, until_s = 0;
};

struct ExecutedReach {
  Motion setpoints;  ///< the controller's set-points, each at the end of its tick
  Motion arm;        ///< the motion of the simulated arm, every millisecond
};

/// Simulates a reach with the whole control loop in virtual time: controller set-points every 50 ms, bridge commands
/// and MuJoCo steps every millisecond, measured joint positions back to the controller every 50 ms. There are no
/// messages and no clock. The servos, the delay and the gains are those of robots/hoap2/robot.yaml.
ExecutedReach execute(const SceneArm& arm, const controller::ReachOptions& options, const JointVector& start,
                      const Eigen::Vector3d& target, double seconds, const std::optional<TimedPush>& push = {});

}  // namespace multireach
