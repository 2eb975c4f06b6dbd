#pragma once

#include <functional>
#include <string>
#include <vector>

#include "controller/task/task_target.hpp"
#include "kinematics/chain.hpp"

namespace multireach::bench {

/// The result of an inverse kinematics solver.
struct IkAnswer {
  JointVector posture;   ///< the solution, or the configuration where the solver gave up
  double simulated_s{};  ///< simulated motion time, for a solver that moves the arm
};

/// An inverse kinematics solver for one arm.
struct IkSolver {
  std::string name;
  std::function<IkAnswer(const controller::TaskTarget& target, const JointVector& start)> solve;
  bool moves = false;  ///< it solves by moving the arm to the target
};

/// Largest error that counts as solved, m and rad.
inline constexpr double kIkTolerance = 1e-5;
/// Most starts of the solvers that restart until a solution is inside the limits.
inline constexpr int kMaxStarts = 200;

/// Whether the hand at joint configuration `posture` meets the target within kIkTolerance.
bool meets(const Chain& chain, const controller::TaskTarget& target, const JointVector& posture);
/// Shifts revolute joints by whole turns where that brings them inside their limits.
JointVector unwound(const Chain& chain, JointVector posture);
/// Whether `posture` is inside the limits (tolerance 1e-9 rad or m).
bool inside_limits(const Chain& chain, const JointVector& posture);

/// The project's solvers: multi-start search for the solution nearest to the start, multi-start search for any
/// solution, and the guarded law with default parameters, run until the arm rests.
std::vector<IkSolver> own_solvers(const Chain& chain);
/// The solvers of Orocos KDL, with the same starts: each once without restarts, and once with restarts from random
/// configurations until the solution is inside the limits. `task` is kPosition or kPose. All joints of `chain` must be
/// revolute.
std::vector<IkSolver> kdl_solvers(const Chain& chain, controller::TaskKind task);

}  // namespace multireach::bench
