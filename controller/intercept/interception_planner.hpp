#pragma once

#include <cstdint>
#include <optional>

#include "controller/intercept/free_fall_filter.hpp"
#include "controller/law/guarded_law.hpp"

namespace multireach::controller {

/// Where and when the hand is to meet a falling object.
struct Interception {
  int64_t utime = 0;         ///< microseconds
  Eigen::Vector3d position;  ///< of the object then, m, in W
  double sigma_m = 0;        ///< standard deviation of the position: root of the covariance's trace
  double error_m = 0;        ///< distance of the hand from it then, as simulated
};

/// Chooses where the hand meets an object in free fall. Of the rest of the flight within reach it takes, in each third,
/// the time that leaves most beyond the least that the joints need. For these, and for the last choice, it simulates
/// the reach with a second law, from the arm's state, and chooses the one in which the hand comes nearest (the hand's
/// error and the standard deviation of the object's position, as squares). The simulation knows no obstacles and no
/// self-collision. Work is counted, not timed: at most kSearches short searches of inverse kinematics, and
/// kSimulations + 1 reaches of up to kHorizon, together about a millisecond. Allocates nothing after the construction.
class InterceptionPlanner {
 public:
  static constexpr int64_t kHorizon = 1'500'000;  ///< us: interceptions are at most so far ahead
  static constexpr int kSearches = 24, kSimulations = 3;
  /// m: an interception in which the hand or the object is expected to be further from it is not tried: more than a
  /// hand's length.
  static constexpr double kLargestError = 0.2;

  /// `parameters`: those of the law that moves the arm.
  InterceptionPlanner(const Chain& chain, const GuardedParameters& parameters);

  /// Chooses an interception for an arm in the state of `law`, whose next step begins at the time `begin`, us, and of
  /// whose steps the robot executes the share `rate`. Keeps the time of the last one unless another is clearly better.
  /// `task`: what the hand must reach besides the position. nullopt when the object does not fall, or when no
  /// interception is worth trying.
  std::optional<Interception> choose(const GuardedLaw& law, const FreeFallFilter& object, int64_t begin, double rate,
                                     const TaskTarget& task);
  void forget() { last_.reset(); }

 private:
  struct Candidate {
    int64_t utime;
    double spare_s;  ///< time beyond the least that the joints need
  };
  std::optional<Interception> simulate(const GuardedLaw& law, const FreeFallFilter& object, int64_t begin, double rate,
                                       int64_t at, TaskTarget task, bool is_last);

  GuardedLaw simulated_;
  MultiStartIk search_;
  JointVector speed_, acceleration_;  // rad/s, rad/s^2 (m/s, m/s^2)
  double steps_per_second_;
  std::optional<Interception> last_;
};

}  // namespace multireach::controller
