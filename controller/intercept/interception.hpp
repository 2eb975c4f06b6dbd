#pragma once

#include <cstdint>
#include <optional>

#include "controller/intercept/free_fall_filter.hpp"
#include "controller/law/guarded_law.hpp"

namespace multireach::controller {

/// Where and when the hand is to meet a falling body.
struct Meeting {
  int64_t utime = 0;         ///< microseconds
  Eigen::Vector3d position;  ///< of the body then, m, in W
  double sigma_m = 0;        ///< standard deviation of the position: root of the covariance's trace
  double miss_m = 0;         ///< how far from it the hand will be then, as rehearsed
};

/// Chooses where the hand meets a body in free fall. Of the rest of the flight within reach it takes, in each third,
/// the time that leaves most beyond the least that the joints need. For these, and for the last choice, it rehearses
/// the reach with a copy of the law, from the arm's state, and chooses the one in which the hand comes nearest (the
/// rehearsed miss and the standard deviation of the body's position, as squares). Work is counted, not timed: at most
/// kSearches short searches of inverse kinematics, and four reaches of up to kHorizon: together about a millisecond,
/// more where the law searches a posture that avoids the arm itself.
class Interception {
 public:
  static constexpr int64_t kHorizon = 1'500'000;  ///< us: meetings are at most so far ahead
  static constexpr int kSearches = 24, kRehearsals = 3;

  Interception(const GuardedLaw& law, const GuardedParameters& parameters);

  /// Chooses a meeting for an arm in the state of `law`, whose next step begins at the time `begin`, us. Keeps the time
  /// of the last one unless another is clearly better. `task`: what the hand must meet besides the position. nullopt
  /// when the body does not fall, or is not within reach at any time from now on.
  std::optional<Meeting> choose(const GuardedLaw& law, const FreeFallFilter& body, int64_t begin,
                                const TaskTarget& task);
  void forget() { meeting_.reset(); }

 private:
  std::optional<Meeting> rehearse(const GuardedLaw& law, const FreeFallFilter& body, int64_t begin, int64_t at,
                                  TaskTarget task, bool chosen_already);

  struct Candidate {
    int64_t utime;
    double spare_s;  ///< time beyond the least that the joints need
  };

  GuardedLaw rehearsed_;
  MultiStartIk search_;
  JointVector speed_, acceleration_;  // rad/s, rad/s^2 (m/s, m/s^2)
  double steps_per_second_;
  std::optional<Meeting> meeting_;
};

}  // namespace multireach::controller
