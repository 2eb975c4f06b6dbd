#pragma once

#include <array>
#include <limits>
#include <optional>

#include "controller/ik/closed_form.hpp"
#include "controller/ik/ik_options.hpp"
#include "controller/ik/levenberg_marquardt.hpp"
#include "kinematics/chain.hpp"
#include "numeric/random.hpp"

namespace multireach::controller {

/// A joint configuration and its task error (distance and weighted rotation, m).
struct IkSolution {
  JointVector theta;
  double error_m = 0;
};

using JointSet = std::array<bool, kMaxJoints>;

/// A search of MultiStartIk, interrupted between two steps. Copies are independent.
struct IkSearch {
  /// How many solutions, the nearest first, are moved along their self-motion towards the given configuration.
  static constexpr int kDrawn = 3;

  TaskTarget target;
  JointVector theta;  ///< the solution is to be near to it
  IkSolution best;    ///< the result once `finished`
  bool finished = false;

  enum class Phase { kClosedForm, kStarts, kApproach } phase = Phase::kClosedForm;
  bool light = false;                                      ///< joints that are much heavier than others stay
  int start = 0, solutions = 0;                            ///< descents ended, and those to a solution
  uint64_t counter = 0;                                    ///< random numbers drawn
  double least = std::numeric_limits<double>::infinity();  ///< least error; then, of `nearest`, least distance
  bool descends = false;                                   ///< whether `descent` has begun
  IkDescent descent{};
  std::array<IkApproach, kDrawn> nearest{};  ///< solutions, the nearest first
  std::array<double, kDrawn> distance{};     ///< theirs; infinite for none
  int approached = 0;                        ///< how many of them have been moved
};

/// Limits a finite target to ten times the arm's reach, along its direction from the shoulder, and its velocity to one
/// reach per step.
TaskTarget within_ten_reaches(const Chain& chain, TaskTarget target);

/// Finds the IK solution inside the joint limits that is nearest to a given configuration: the first theta_T of Sect.
/// 3.4. Position targets of a shoulder-elbow arm have a closed form. All others use damped Newton steps from seeded
/// random starts, then move the best solutions along their self-motion towards the given configuration. Joints that
/// weigh much more than the lightest move only when no solution without them was found.
class MultiStartIk {
 public:
  explicit MultiStartIk(const Chain& chain, const IkOptions& options = {}, const Tool& tool = {});

  /// The solution for the position `x_T` nearest to `theta`. nullopt when none was found: the point is unreachable, or,
  /// for an arm without closed form, no start converged to it.
  [[nodiscard]] std::optional<JointVector> nearest(const Eigen::Vector3d& x_T, const JointVector& theta) const;
  /// The solution for any target nearest to `theta`. When there is none, the configuration found with the smallest task
  /// error. The target and `theta` must be finite.
  IkSolution best(const TaskTarget& target, const JointVector& theta) const;
  /// The same search in slices: begin(), then continue_search() until it returns true; then `best` of the search is the
  /// result, the same as that of best(). One unit of work is one computation of the kinematics with one linear system,
  /// some 0.4 to 1 us; a call does at most `work` + 3. A closed form counts as one call's work.
  void begin(const TaskTarget& target, const JointVector& theta, IkSearch& search) const;
  bool continue_search(IkSearch& search, int work) const;
  /// The first solution found, starting from `theta`, then from the seeded starts. Takes a fraction of the time of
  /// `best`, but the solution may be far from `theta`. When there is none, the configuration with the smallest error.
  IkSolution first(const TaskTarget& target, const JointVector& theta) const;
  /// Like `nearest`, by the closed form alone, which may miss solutions between two samples. nullopt without a closed
  /// form.
  std::optional<JointVector> closed_form_nearest(const Eigen::Vector3d& x_T, const JointVector& theta) const {
    if (!closed_form_ik_) return std::nullopt;
    return closed_form_ik_->nearest(x_T, theta);
  }
  bool closed_form() const { return closed_form_ik_.has_value(); }
  /// Requires closed_form().
  const ClosedFormIk& closed_form_ik() const { return *closed_form_ik_; }
  const IkOptions& options() const { return options_; }
  /// The joints of infinite weight.
  const JointSet& locked() const { return locked_; }
  /// Draws every joint that is not fixed uniformly from its range.
  void draw(const CounterRandom& random, uint64_t& counter, const JointSet& fixed, JointVector& posture) const;

 private:
  void begin_starts(bool light, const JointVector& theta, IkSearch& search) const;
  /// One descent from a start, or a part of it. Returns its work.
  int continue_starts(IkSearch& search, int work) const;
  int continue_approach(IkSearch& search, int work) const;
  const LevenbergMarquardtIk& solver_of(const IkSearch& search) const {
    return search.light ? *light_solver_ : solver_;
  }

  Chain chain_;
  IkOptions options_;
  LevenbergMarquardtIk solver_;
  JointSet locked_{}, heavy_{};                       // heavy_: those much heavier than the lightest, and locked ones
  std::optional<LevenbergMarquardtIk> light_solver_;  // moves only joints that are not heavy; where some are
  std::optional<ClosedFormIk> closed_form_ik_;
};

}  // namespace multireach::controller
