#pragma once

#include <optional>
#include <string>

#include "controller/reach_controller.hpp"
#include "studies/figures/motion.hpp"

namespace multireach {

/// A force on a link of the arm, in the frame of the world.
struct TimedPush {
  std::string link;
  Eigen::Vector3d force_n;
  double from_s = 0, until_s = 0;
};

struct ExecutedReach {
  Motion setpoints;  ///< what the controller sent, each at the end of its tick
  Motion arm;        ///< what the arm of MuJoCo did, every millisecond
};

/// A reach as the whole loop makes it, in virtual time: the controller's set-points every 50 ms, the bridge's commands
/// and MuJoCo's steps every millisecond, the measured posture back every 50 ms. No messages and no clock; the servos,
/// the delay and the gains are those of robots/hoap2/robot.yaml.
ExecutedReach execute(const SceneArm& arm, const controller::ReachOptions& options, const JointVector& start,
                      const Eigen::Vector3d& target, double seconds, const std::optional<TimedPush>& push = {});

}  // namespace multireach
