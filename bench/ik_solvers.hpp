#pragma once

#include <functional>
#include <string>
#include <vector>

#include "controller/task/hand_target.hpp"
#include "kinematics/chain.hpp"

namespace multireach::bench {

/// What a solver of inverse kinematics answers.
struct IkAnswer {
  JointVector posture;   ///< what it found, or where it gave up
  double simulated_s{};  ///< of the time that the arm takes to go there, for a solver that moves it
};

/// A solver of inverse kinematics for one arm.
struct IkSolver {
  std::string name;
  std::function<IkAnswer(const controller::HandTarget& target, const JointVector& start)> solve;
  bool moves = false;  ///< its answer is reached by moving
};

/// How near to its target a hand must be, m and rad.
inline constexpr double kIkTolerance = 1e-5;
/// Starts at most, of the solvers that begin again where they have not found a posture inside the limits.
inline constexpr int kMostStarts = 200;

/// Whether the hand at `posture` meets the target.
bool meets(const Chain& chain, const controller::HandTarget& target, const JointVector& posture);
/// The posture with whole turns taken off turning joints, where that brings them inside their limits.
JointVector unwound(const Chain& chain, JointVector posture);
/// Whether it is inside the limits (1e-9 rad or m).
bool inside_limits(const Chain& chain, const JointVector& posture);

/// The project's own: the search for the nearest posture, the first posture found, and the guarded law at its defaults,
/// run until the arm rests.
std::vector<IkSolver> own_solvers(const Chain& chain);
/// Orocos KDL's, with the same starts; each once as it is, and once begun again from random postures until its answer
/// meets the target inside the limits. `aim` is kPosition or kPose. All joints of `chain` turn.
std::vector<IkSolver> kdl_solvers(const Chain& chain, controller::Aim aim);

}  // namespace multireach::bench
