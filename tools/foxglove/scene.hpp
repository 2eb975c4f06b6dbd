#pragma once

#include <map>
#include <multireach/images_t.hpp>
#include <multireach/obstacles_t.hpp>
#include <multireach/target_t.hpp>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "imaging/stereo_rig.hpp"
#include "runtime/robot_config.hpp"
#include "tools/foxglove/images.hpp"

namespace multireach {

/// What Foxglove's and Lichtblick's 3-D view shows of a run without any set-up, made from the project's messages:
/// frames of the arm's links and of the cameras on /tf, and arm, targets and obstacles on /scene. The root frame is W,
/// named as the chain's base link.
class FoxgloveScene {
 public:
  /// `rig`: the cameras, with X_WL; null where they are not known.
  FoxgloveScene(const RobotConfig& robot, const StereoRig* rig);

  /// What follows from a message on this channel: often nothing. The arm is drawn at most 30 times a second, and the
  /// newest obstacles again once a second.
  /// `utime`: the time of receipt, microseconds, which counts because the robot's clock may be another one.
  std::vector<FoxgloveMessage> messages(std::string_view channel, std::span<const uint8_t> bytes, int64_t utime);

 private:
  std::vector<FoxgloveMessage> arm(std::span<const uint8_t> bytes, int64_t utime);
  std::vector<FoxgloveMessage> target(const target_t& target, int64_t utime);
  std::vector<FoxgloveMessage> obstacles(const obstacles_t& obstacles, int64_t utime);
  std::vector<FoxgloveMessage> calibrations(const images_t& images) const;

  Chain chain_;
  std::string root_;
  std::vector<std::string> link_;  // that each joint moves
  double radius_m_;                // of the links, as drawn
  std::vector<std::pair<std::string, CameraModel>> cameras_;
  std::vector<Eigen::Isometry3d> X_WC_;
  std::optional<int64_t> drawn_utime_, repeated_utime_;
  nlohmann::ordered_json obstacles_;  // their newest drawing, repeated for those who did not see it
  std::set<std::string> targets_;     // that are shown
};

}  // namespace multireach
