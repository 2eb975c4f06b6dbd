#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <variant>

#include "controller/intercept/interception_planner.hpp"
#include "controller/law/guarded_law.hpp"
#include "controller/law/paper_law.hpp"
#include "controller/law/reaching_law.hpp"
#include "controller/target_filter.hpp"

namespace multireach::controller {

/// What to do while the target is lost. The law `paper` also does this while the target is unreachable.
enum class OnTargetLost {
  kHoldLastTarget,  ///< continue to the last target that was within reach
  kGoToRest,        ///< go to the rest configuration
  kStop,            ///< stop where the arm is
};

/// The frame in which ReachOptions gives the tool's direction or orientation.
enum class OrientationFrame {
  kWorld,   ///< W: fixed
  kTarget,  ///< the target's own, which its observations must then hold
};

/// How the controller uses measured joint positions after the start.
enum class Feedback {
  kOpen,      ///< not at all: it integrates its own joint positions from the measured start, as in the paper
  kMeasured,  ///< the command follows the arm when something pushes the arm away; a deviation that lasts for tens of
              ///< seconds (sag, a wrongly calibrated joint) is learnt as an offset and not compensated
};

/// When ticks are computed.
enum class TickTimes {
  kPeriodic,   ///< every tick_us from the first target
  kOnTargets,  ///< at each target that is seen, a quarter of tick_us or more after the last tick; else tick_us after it
};

struct ReachOptions {
  /// The controller overwrites steps_per_second and ik of GuardedParameters with the values below.
  std::variant<GuardedParameters, PaperParameters> law{};
  int64_t tick_us = 50000;  ///< period of the set-points: 20 Hz, Sect. 4
  int steps_per_tick = 7;   ///< integration steps per tick_us, each "roughly 7 milliseconds" (Fig. 10)
  TickTimes ticks = TickTimes::kOnTargets;
  TargetFilter::Options target{};
  /// The hand aims at where the target will be this much later. A set-point holds for the end of its tick; what passes
  /// besides, from the image to the controller and from the bridge to the robot's motion, belongs here.
  int64_t prediction_us = 0;
  /// The target is thrown: the hand waits in the rest configuration until the target falls freely, then goes where it
  /// will be. Only with GuardedParameters.
  std::optional<FreeFallFilter::Options> intercept{};
  double drift_m = 0.01;  ///< law `paper`: search theta_T again when K(theta_T) is further than this from the target
  int64_t lost_after_us = 200000;  ///< a target not seen for longer than this is lost
  OnTargetLost on_target_lost = OnTargetLost::kHoldLastTarget;
  JointVector rest{};  ///< rest configuration; empty: where the arm was at start
  Feedback feedback = Feedback::kOpen;
  /// rad (m): a joint measured within this distance of the commands of the last 0.3 s counts as undisturbed.
  double disturbance_threshold = 0.02;
  TaskKind task = TaskKind::kPosition;  ///< what the end effector must reach besides the position
  OrientationFrame orientation_frame = OrientationFrame::kWorld;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();       ///< kPointing: direction of the tool, unit vector
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();  ///< kPose: rotation from the hand's frame
  IkOptions ik{};
};

/// Why the arm stands still short of a target that would be within its reach.
enum class Blocked {
  kNo,
  kTargetInObstacle,  ///< the target is inside an obstacle, or too near to it for the end effector
  kObstacle,          ///< an obstacle, or the arm's own links, in the way
  kUnknown,           ///< e.g. joint limits
};

enum class ReachMode {
  kWaiting,
  kReaching,
  kHolding,
  kResting,
  kNotStarted,  ///< start() or restart_grid() has not been called: the output holds nothing else
};

/// The output of one tick. Vectors have one element per joint of the chain.
struct ReachOutput {
  int64_t utime = 0;  ///< nominal time of the tick, microseconds
  int64_t tick = 0;   ///< index of the tick, from 0
  ReachMode mode = ReachMode::kWaiting;
  bool target_lost = false;
  bool target_unreachable = false;
  bool target_flickers = false;  ///< it jumps to and fro; the arm goes on to where it was when that was noticed
  Blocked blocked = Blocked::kNo;
  double distance_m = 0;  ///< from the end effector to the target that was asked for; 0 before the first
  JointVector theta;      ///< rad or m
  JointVector velocity;   ///< rad/s or m/s
  JointVector theta_target;
  JointVector weights;     ///< w_x / w_theta at theta, rad^2/m^2
  Eigen::Vector3d x, x_T;  ///< position of the end effector and the position it goes to, m, in W
  double gamma = 0;        ///< rad^2/m^2
  double condition_number = 1;
  double attractor_residual_m = 0;  ///< |target - K(theta_T)|
  int64_t ik_searches = 0;
  std::optional<Interception> interception{};  ///< ReachOptions::intercept: where the hand is to meet the target
};

/// The reaching controller as a stage: receives target observations, measured joint positions and obstacles; computes
/// one set-point per tick (20 Hz or more, TickTimes). A tick integrates as many steps as the time since the last one
/// holds, so a target that is waited for less changes nothing but when the arm knows of it. Deterministic: the same
/// calls in the same order give the same outputs.
class ReachController {
 public:
  /// Throws std::invalid_argument for invalid options (a rest configuration outside the limits, a period or a number
  /// of steps that is not positive, parameters that the law refuses).
  ReachController(const Chain& chain, const ReachOptions& options);

  /// Largest absolute time, microseconds; some 36 000 years.
  static constexpr int64_t kMaxTime = int64_t{1} << 60;

  const Chain& chain() const { return chain_; }
  const ReachOptions& options() const { return options_; }

  /// Starts at rest at `theta`, the measured joint positions (finite, size() elements). Call it before the first tick.
  /// Returns false, and changes nothing, when `theta` is invalid.
  bool start(const JointVector& theta);
  bool started() const { return started_; }

  /// Takes an observation of the target. Returns false, and ignores it, when it is marked as seen but not finite or
  /// without the orientation that OrientationFrame::kTarget needs, when it is older than the newest one, or when its
  /// time is further than kMaxTime from 0.
  bool observe(const TargetObservation& observation);
  /// Takes the measured joint positions (Feedback::kMeasured). Returns false, and ignores them, when they are not
  /// finite, have another size, or are beyond 1e5 rad.
  bool observe_robot(const JointVector& theta);

  /// Replaces all obstacles. Returns how many were refused. The law `paper`, and an arm without a body
  /// (link_radius_m = 0), refuse all.
  int set_obstacles(std::span<const Obstacle> obstacles) { return law_->set_obstacles(obstacles); }

  /// How much of each tick the robot executes, 0 to 1: the bridge slows down or stops. The controller then integrates
  /// as much less, so that it does not run ahead. Others are ignored.
  void set_rate(double rate);

  /// Restarts the ticks with tick 0 at `utime`: for the first target, and after a jump of the target's clock. Returns
  /// false, and changes nothing, when `utime` is further than kMaxTime from 0.
  bool restart_grid(int64_t utime);
  /// The next observations are of another target: that they are elsewhere is no flicker.
  void expect_other_target() {
    jumps_.fill(std::nullopt);
    flickers_ = false;
  }
  /// Ends the ticks until restart_grid(). start() may then be called again.
  void stop_ticks() { grid_origin_.reset(); }
  /// The time of the next tick, a whole number of integration steps after the first; nullopt before restart_grid().
  std::optional<int64_t> next_tick() const;
  /// Where the newest target that was seen is, filtered, m, in W; nothing before the first.
  std::optional<Eigen::Vector3d> target_position() const {
    return last_seen_ ? std::optional(last_position_) : std::nullopt;
  }
  /// Whether a target of the next tick's time, or a newer one, is there: nothing is gained by waiting for another.
  bool target_waits() const { return last_seen_ && grid_origin_ && *last_seen_ >= *next_tick(); }
  /// Computes the next tick. Call start() and restart_grid() first: before, the output is of ReachMode::kNotStarted and
  /// has no joint positions.
  ReachOutput tick();

 private:
  static constexpr int kCommandsWithin = 6;  // tick_us: the time for which commands are compared with the robot
  static constexpr int kCommandHistory = 4 * kCommandsWithin;  // as many as ticks fit into that time

  /// A command, and the integration steps that were due since the first tick.
  struct PastCommand {
    JointVector theta;
    int64_t step = 0;
  };

  int64_t time_of_step(int64_t step) const { return *grid_origin_ + step * options_.tick_us / options_.steps_per_tick; }
  void bring_tick_forward(int64_t utime);
  void update_goal(int64_t now, int64_t begin);
  void note_jump(int64_t utime);
  void track_target(int64_t now, int64_t begin);
  void intercept_target(int64_t begin);
  void handle_lost_target();
  void forget_flight();
  TaskTarget task_target(const Eigen::Vector3d& position, const Eigen::Vector3d& velocity) const;
  void compensate_disturbance(int64_t interval_us);
  void record_command();
  Blocked blocked(double distance_m, int64_t interval_us);
  double steps_per_second() const { return 1e6 * options_.steps_per_tick / static_cast<double>(options_.tick_us); }

  Chain chain_;
  ReachOptions options_;
  std::unique_ptr<ReachingLaw> law_;
  bool started_ = false;
  JointVector rest_;
  std::optional<int64_t> grid_origin_;
  int64_t tick_ = 0;
  int64_t last_step_ = 0, next_step_ = 0;  // of the last and the next tick: integration steps since grid_origin_
  int64_t due_steps_ = 0;                  // in all ticks so far, also before the ticks were restarted
  double rate_ = 1, owed_steps_ = 0;       // integration steps not done yet, less than one
  JointVector rested_;                     // where the arm has been for still_us_
  int64_t still_us_ = 0;

  std::optional<int64_t> newest_;                            // time of the newest observation, seen or not
  std::optional<int64_t> last_seen_;                         // time of the newest observation that was seen
  Eigen::Vector3d last_position_ = Eigen::Vector3d::Zero();  // filtered target position at last_seen_
  TargetFilter filter_;
  Eigen::Vector3d direction_;    // kPointing: of the tool, in W
  Eigen::Matrix3d orientation_;  // kPose: R_WT
  FreeFallFilter fall_;
  std::optional<InterceptionPlanner> planner_;
  std::optional<Interception> interception_;
  bool jumped_ = false;                          // the target is new or has jumped since the last tick
  std::array<std::optional<int64_t>, 3> jumps_;  // times of the last jumps, the newest first
  bool flickers_ = false;
  Eigen::Vector3d held_position_ = Eigen::Vector3d::Zero();  // of the target when it was followed last
  ReachMode mode_ = ReachMode::kWaiting;
  bool lost_ = false, unreachable_ = false, dwelling_ = false;
  std::optional<JointVector> measured_;  // newest measurement since the last tick
  JointVector offset_;                   // lasting deviation of the arm from the commands: sag, calibration error
  std::array<PastCommand, kCommandHistory> commands_;
  int64_t commands_recorded_ = 0;
};

}  // namespace multireach::controller
