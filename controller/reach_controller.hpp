#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <variant>

#include "controller/law/guarded_law.hpp"
#include "controller/law/paper_law.hpp"
#include "controller/law/reaching_law.hpp"
#include "controller/target_filter.hpp"

namespace multireach::controller {

/// What to do while the target is lost, or out of reach of a law that does not pursue it then (`paper`).
enum class WithoutTarget {
  kHoldLastTarget,  ///< go on to the last target that was within reach
  kGoToRest,        ///< go to the rest posture
  kStay,            ///< stop where the arm is
};

/// Whose posture the controller goes on from.
enum class Feedback {
  kOpen,      ///< its own, integrated from the measured one at the start, as in the paper
  kMeasured,  ///< the same, drawn after the arm where that is measured to be elsewhere: a push is taken up; what stays
              ///< for tens of seconds (an arm that sags, a joint that is calibrated wrongly) is let be
};

struct ReachOptions {
  /// Of the guarded law, steps_per_second and posture_search are set from what follows.
  std::variant<GuardedParameters, PaperParameters> law{};
  int64_t tick_us = 50000;  ///< period of the set-points: 20 Hz, Sect. 4
  int steps_per_tick = 7;   ///< integration steps in a tick, each "roughly 7 milliseconds" (Fig. 10)
  TargetFilter::Options target{};
  double drift_m = 0.01;  ///< law `paper`: theta_T is chosen anew when K(theta_T) is further than this from the target
  int64_t lost_after_us = 200000;  ///< a target not seen for longer than this is lost
  WithoutTarget without_target = WithoutTarget::kHoldLastTarget;
  JointVector rest{};  ///< the rest posture; empty for "where the arm was at start"
  Feedback feedback = Feedback::kOpen;
  double push_from =
      0.02;  ///< rad (m): a joint measured less than this beside the commands of the last 0.3 s is in place
  Aim aim = Aim::kPosition;  ///< what is asked of the hand besides the target's position, and how it is fixed in W:
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();       ///< where the tool points (kPointing)
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();  ///< R_WT (kPose)
  PostureSearchOptions posture_search{};
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
  JointVector weights;     ///< w_x / w_theta at theta, rad^2/m^2
  Eigen::Vector3d x, x_T;  ///< m, in W; x_T is where the hand is going
  double gamma = 0;        ///< rad^2/m^2
  double condition_number = 1;
  double attractor_residual_m = 0;  ///< |target - K(theta_T)|
  int64_t posture_choices = 0;
};

/// The reaching controller as a stage: observations of the target and ticks of a 20 Hz grid in, set-points out. The
/// same calls in the same order give the same outputs.
class ReachController {
 public:
  /// Throws std::invalid_argument for options that make no sense (a rest posture outside the limits, a period or a
  /// number of steps that is not positive, parameters that the law refuses).
  ReachController(const Chain& chain, const ReachOptions& options);

  /// Microseconds; some 36 000 years.
  static constexpr int64_t kLargestTime = int64_t{1} << 60;

  const Chain& chain() const { return chain_; }
  const ReachOptions& options() const { return options_; }

  /// Puts the arm at rest at `theta` (finite, size() elements), the measured posture. Needed before the first tick;
  /// returns false, and changes nothing, when it cannot be a posture of the arm.
  bool start(const JointVector& theta);
  bool started() const { return started_; }

  /// Takes an observation. Returns false, and ignores it, when it claims to be seen and is not finite, or its time is
  /// before that of the newest one, or further than kLargestTime from 0.
  bool observe(const TargetObservation& observation);
  /// Takes the arm's measured posture (Feedback::kMeasured). Returns false, and ignores it, when it is not finite, of
  /// another size, or beyond 1e5 rad.
  bool observe_robot(const JointVector& theta);

  /// Replaces all obstacles. Returns how many were refused; all of them under the law `paper`, or without a body.
  int set_obstacles(std::span<const Obstacle> obstacles) { return law_->set_obstacles(obstacles); }

  /// Starts a new grid whose tick 0 is at `utime`, for the first target and after a jump of its clock. Returns false,
  /// and changes nothing, when that is further than kLargestTime from 0.
  bool restart_grid(int64_t utime);
  /// The time of the next tick; nothing before restart_grid.
  std::optional<int64_t> next_tick() const;
  /// Computes the next tick. Needs start() and restart_grid() before.
  ReachOutput tick();

 private:
  static constexpr int kRemembered = 6;  // ticks of 50 ms

  void choose_goal(int64_t now);
  void pursue(int64_t now);
  void fall_back();
  void feel_pushes();
  void remember_command();
  double steps_per_second() const { return 1e6 * options_.steps_per_tick / static_cast<double>(options_.tick_us); }

  Chain chain_;
  ReachOptions options_;
  std::unique_ptr<ReachingLaw> law_;
  bool started_ = false;
  JointVector rest_;
  std::optional<int64_t> grid_origin_;
  int64_t tick_ = 0;

  std::optional<int64_t> newest_;                         // time of the newest observation, seen or not
  std::optional<int64_t> last_seen_;                      // time of the newest one that was seen
  Eigen::Vector3d last_place_ = Eigen::Vector3d::Zero();  // of the target then
  TargetFilter filter_;
  bool jumped_ = false;  // since the last tick
  ReachMode mode_ = ReachMode::kWaiting;
  bool lost_ = false, out_of_reach_ = false, staying_ = false;
  std::optional<JointVector> measured_;  // since the last tick
  JointVector offset_;                   // where the arm always is beside the commands: sag, calibration
  std::array<JointVector, kRemembered> commands_;
  int64_t commands_known_ = 0;
};

}  // namespace multireach::controller
