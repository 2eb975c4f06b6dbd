#pragma once

#include <cstdint>
#include <optional>

#include "controller/paper_law.hpp"
#include "controller/posture_search.hpp"

namespace multireach::controller {

/// Where the target is at a time, or that it is not seen.
struct TargetObservation {
  int64_t utime = 0;                                   ///< microseconds
  bool seen = false;                                   ///< when false, position and velocity mean nothing
  Eigen::Vector3d position;                            ///< m, in W
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s, in W
};

/// What to do while there is no target within reach.
enum class WithoutTarget {
  kHoldLastTarget,  ///< go on to the last target that was within reach
  kGoToRest,        ///< go to the rest posture
};

struct ReachOptions {
  PaperParameters law;
  int64_t tick_us = 50000;  ///< period of the set-points: 20 Hz, Sect. 4
  int steps_per_tick = 7;   ///< integration steps in a tick, each "roughly 7 milliseconds" (Fig. 10)
  double jump_m = 0.02;     ///< a target that moves further between two observations has jumped: theta_T is chosen anew
  double drift_m = 0.01;    ///< theta_T is chosen anew when K(theta_T) is further than this from the target,
                            ///< or when it has left the limits
  int64_t lost_after_us = 200000;  ///< a target not seen for longer than this is lost
  WithoutTarget without_target = WithoutTarget::kHoldLastTarget;
  JointVector rest;  ///< the rest posture; empty for "where the arm was at start"
  PostureSearchOptions posture_search;
};

enum class ReachMode { kWaiting, kReaching, kHolding, kResting };

/// What a tick computed. Vectors have one element per joint of the chain.
struct ReachOutput {
  int64_t utime = 0;  ///< nominal time of the tick, microseconds
  int64_t tick = 0;   ///< index on the grid
  ReachMode mode = ReachMode::kWaiting;
  bool target_lost = false;
  bool target_out_of_reach = false;
  JointVector theta;     ///< rad or m
  JointVector velocity;  ///< rad/s or m/s
  JointVector theta_target;
  JointVector weights;     ///< Eq. (28) at theta, rad^2/m^2
  Eigen::Vector3d x, x_T;  ///< m, in W
  double condition_number = 1;
  double attractor_residual_m = 0;  ///< |x_T - K(theta_T)|
  int64_t posture_choices = 0;
};

/// The reaching controller as a stage: observations of the target and ticks of a 20 Hz grid in, set-points out. It
/// integrates its own posture from where the arm was at the start, as the paper's does. The same calls in the same
/// order give the same outputs.
class ReachController {
 public:
  /// Throws std::invalid_argument for options that make no sense (a rest posture outside the limits, a period or a
  /// number of steps that is not positive, gains or gamma that are negative or not finite).
  ReachController(const Chain& chain, const ReachOptions& options);

  const Chain& chain() const { return chain_; }
  const ReachOptions& options() const { return options_; }

  /// Puts the arm at rest at `theta` (finite, size() elements), the measured posture. Needed before the first tick;
  /// returns false, and changes nothing, when the posture is not finite or of another size.
  bool start(const JointVector& theta);
  bool started() const { return started_; }

  /// Takes an observation. Returns false, and ignores it, when it claims to be seen and is not finite, or its time is
  /// before that of the newest one.
  bool observe(const TargetObservation& observation);

  /// Starts a new grid whose tick 0 is at `utime`, for the first target and after a jump of its clock.
  void restart_grid(int64_t utime);
  /// The time of the next tick; nothing before restart_grid.
  std::optional<int64_t> next_tick() const;
  /// Computes the next tick. Needs start() and restart_grid() before.
  ReachOutput tick();

 private:
  struct Goal {
    Eigen::Vector3d x_T;
    Eigen::Vector3d velocity;  // m per step
    ReachMode mode;
  };

  void choose_goal(int64_t now);
  bool choose_posture(const Eigen::Vector3d& x_T);
  void pursue(const TargetObservation& target);
  void fall_back();
  void step();

  Chain chain_;
  ReachOptions options_;
  PostureSearch search_;
  PaperState state_;
  bool started_ = false;
  JointVector rest_;
  std::optional<int64_t> grid_origin_;
  int64_t tick_ = 0;

  std::optional<TargetObservation> newest_;    // the newest observation, seen or not
  std::optional<TargetObservation> sighting_;  // the newest one that was seen
  std::optional<Goal> goal_;
  std::optional<Eigen::Vector3d> unreachable_;  // the target for which the last search found no posture
  bool lost_ = false, out_of_reach_ = false;
  int64_t posture_choices_ = 0;
};

}  // namespace multireach::controller
