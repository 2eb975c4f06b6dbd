#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "kinematics/chain.hpp"

namespace multireach {

/// An object thrown towards the arm: it falls freely from its release at time 0.
struct Throw {
  Eigen::Vector3d release;   ///< m, in W
  Eigen::Vector3d velocity;  ///< m/s, in W, at the release
  double flight_s = 0;       ///< until it comes to a position that the hand can reach

  Eigen::Vector3d position(double t) const;  ///< m, at time t, s
};

/// How throws are seen and what counts as met.
struct ThrowOptions {
  double sigma_m = 0.003;  ///< standard deviation of each coordinate of an observed position
  double near_m = 0.03;    ///< met: the hand comes as near as this to the object
  double drag = 0;         ///< 1/m: deceleration by the air, as a part of the squared speed; the controller knows none
};

/// The outcome of one throw.
struct ThrowResult {
  double closest_m = 0;       ///< least distance of the hand to the object
  bool in_time = false;       ///< a hand that knew the throw at its release could be at a position of its path in time
  bool seen_in_time = false;  ///< the same, from the third image on: fewer show no acceleration
};

/// Throw number `index` of `seed` at an arm that waits in the middle of its joints' ranges: 0.5 to 0.9 s of flight,
/// from 1.5 to 3 m away and at most 0.3 m above or below the position to which it leads, which is the hand's position
/// at joint positions that are uniform inside the limits.
Throw sample_throw(const Chain& chain, uint64_t seed, uint64_t index);
/// The joint positions in which the arm waits.
JointVector waiting_posture(const Chain& chain);

/// Plays one throw to the controller with `motion: intercept`: images at 30 Hz, whose noise is drawn from `seed` and
/// `index`, each taken 30 ms before the robot shows the resulting motion.
ThrowResult run_throw(const Chain& chain, const Throw& thrown, const ThrowOptions& options, uint64_t seed,
                      uint64_t index);

/// Throws 0 to `throws` - 1. The JSON holds how many were in time, were met, and the closest approaches.
nlohmann::json run_throws(const Chain& chain, int64_t throws, uint64_t seed, const ThrowOptions& options);
/// The same as a Markdown table of one row.
std::string throws_table(const nlohmann::json& result);

}  // namespace multireach
