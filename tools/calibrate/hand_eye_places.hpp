#pragma once

#include <string>
#include <vector>

#include "kinematics/chain.hpp"
#include "tools/calibrate/hand_eye.hpp"

namespace multireach {

/// Which sightings of a log are taken.
struct LogChoice {
  std::string target;      ///< the target's name; "" where there is only one
  double still_m = 0.002;  ///< the hand stands while it stays within this
};

/// The places at which the hand stood and the target was seen, from ROBOT_STATE (by the chain's forward kinematics) and
/// TARGET, of which `X_WL`, the camera's pose that the vision stage had, is taken away. One place for each stand: the
/// mean of the sightings after its first 0.3 s, so neither the robot's and the cameras' clocks nor the delay between
/// them matter. A stand in which the target moves gives none: the hand does not hold it, or something else was seen.
/// Throws InputError when the log holds nothing of this, and std::runtime_error when the target moves in more than one
/// stand and more than a quarter of them: a hand that follows a target would give the camera's old pose back.
std::vector<HandEyePlace> places_from_log(const std::string& path, const Chain& chain, const Eigen::Isometry3d& X_WL,
                                          const LogChoice& choice);

/// The same from a table with the columns seen_x_m, seen_y_m, seen_z_m (in the left camera's frame), hand_x_m,
/// hand_y_m, hand_z_m (in the robot's base), and where known hand_qw, hand_qx, hand_qy, hand_qz (the hand's
/// orientation) and sigma_m (of what is seen, per coordinate; else `sigma_m`). Throws InputError that names file and
/// line.
std::vector<HandEyePlace> places_from_csv(const std::string& path, double sigma_m);

}  // namespace multireach
