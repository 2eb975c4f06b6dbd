#include "robot_bridge/bridge.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace multireach::robot_bridge {
namespace {

constexpr double kImpossible = 1e6;              // rad or m: no joint has such a position; larger values could overflow
constexpr int64_t kFarthest = int64_t{1} << 60;  // us: times within it can be subtracted and added to
constexpr double kImpliedSpeed = 1.5;            // times the speed limit: a set-point that implies more is refused
constexpr double kApproachSpeed = 0.2;           // speed override while the robot is far from the set-points
// For so many periods of the set-points those of a sender that resumes far away are refused, which asks it to start
// again from where the robot is, before the robot approaches them slowly.
constexpr int kAskFirst = 10;
constexpr double kSlowing = 2;  // 1/s: the speed falls no faster, as the motion would overshoot its path
constexpr double kMicro = 1e-6;
// Where more than one in twenty set-points is too early or too old, the first one of the motion was itself late or
// early: after five of them the motion ends, and begins again with the time of another.
constexpr int kMistimed = 20, kMaxMistimed = 80;

const BridgeOptions& checked(const BridgeOptions& options) {
  const auto require = [](bool valid, const char* sentence) {
    if (!valid) throw std::invalid_argument(sentence);
  };
  require(options.period_us > 0 && options.setpoint_period_us > 0, "the bridge's periods must be positive");
  require(options.delay_us >= 0 && options.delay_us <= 3 * options.setpoint_period_us,
          "the bridge's delay must be from zero to three periods of the set-points");
  require(options.speed_where_unlimited > 0, "the speed of joints without a limit must be positive");
  require(options.max_setpoint_age_us > 0 && options.max_setpoint_lead_us > 0 && options.setpoint_timeout_us > 0 &&
              options.max_start_distance > 0,
          "the bridge's tolerances for set-points must be positive");
  return options;
}

}  // namespace

const char* name_of(BridgeState state) {
  switch (state) {
    case BridgeState::kIdle:
      return "idle";
    case BridgeState::kArmed:
      return "armed";
    case BridgeState::kRunning:
      return "running";
    case BridgeState::kStopping:
      return "stopping";
    case BridgeState::kFault:
      break;
  }
  return "fault";
}

const char* name_of(SetpointVerdict verdict) {
  switch (verdict) {
    case SetpointVerdict::kAccepted:
      return "accepted";
    case SetpointVerdict::kNotReady:
      return "the bridge is not ready";
    case SetpointVerdict::kInvalid:
      return "invalid";
    case SetpointVerdict::kOtherRun:
      return "another sender is followed";
    case SetpointVerdict::kNotNewer:
      return "not newer than the last";
    case SetpointVerdict::kTooOld:
      return "too old";
    case SetpointVerdict::kTooEarly:
      return "too far in the future";
    case SetpointVerdict::kTooFast:
      return "too fast";
    case SetpointVerdict::kFarFromRobot:
      break;
  }
  return "the robot is elsewhere or moves";
}

Bridge::Bridge(const Chain& chain, const BridgeOptions& options)
    : chain_(chain),
      options_(checked(options)),
      generator_(motion_limits(chain, options.speed_where_unlimited, options.acceleration, options.jerk),
                 static_cast<double>(options.period_us) * kMicro),
      interpolator_(options.setpoint_period_us, options.delay_us),
      guard_(chain, static_cast<double>(options.period_us) * kMicro, options.speed_where_unlimited),
      monitor_(generator_.limits(), options.monitor, options.period_us) {}

bool Bridge::measured(const Measurement& measurement, MeasurementVerdict& verdict) {
  const bool known =
      monitor_.knows_robot() && monitor_.newest().run == measurement.run && monitor_.newest().real == measurement.real;
  verdict = monitor_.update(measurement, next_tick_.has_value());
  if (verdict != MeasurementVerdict::kAccepted) return false;
  measured_since_gap_ = true;
  if (measurement.real && !known) disable();  // a real robot waits for an explicit enable
  const bool ready = enabled_ && !measurement.faulted;
  if (state_ == BridgeState::kIdle && ready) {
    state_ = BridgeState::kArmed;
    cause_ = "";
  }
  if (state_ == BridgeState::kArmed && !ready && !next_tick_) state_ = BridgeState::kIdle;
  return true;
}

void Bridge::enable() {
  enabled_ = true;
  if (state_ == BridgeState::kArmed && !next_tick_) state_ = BridgeState::kIdle;  // until the robot's next state
}

void Bridge::disable() {
  enabled_ = false;
  if (state_ == BridgeState::kRunning || state_ == BridgeState::kArmed) decelerate("disabled");
  if (!next_tick_ && state_ != BridgeState::kFault) state_ = BridgeState::kIdle;
}

bool Bridge::reset() {
  if (state_ != BridgeState::kFault || next_tick_ || !measured_since_gap_ || monitor_.late() || !monitor_.stands())
    return false;
  monitor_.reset();
  cause_ = "";
  run_ = 0;
  state_ = BridgeState::kIdle;
  return true;
}

void Bridge::set_speed(double speed) {
  if (speed >= 0 && speed <= 1) speed_ = speed;
}

SetpointVerdict Bridge::setpoint(const Setpoint& setpoint, bool& restarted) {
  restarted = false;
  const auto n = chain_.size();
  const auto is_valid = [n](const JointVector& values) {
    return values.size() == n && values.allFinite() && values.cwiseAbs().maxCoeff() < kImpossible;
  };
  const bool timed = setpoint.utime > -kFarthest && setpoint.utime < kFarthest;
  if (!timed || !is_valid(setpoint.theta) || !is_valid(setpoint.velocity)) return SetpointVerdict::kInvalid;
  if (state_ == BridgeState::kIdle || state_ == BridgeState::kFault || !enabled_) return SetpointVerdict::kNotReady;
  if (state_ == BridgeState::kArmed) return start_following(setpoint, restarted);
  const SetpointVerdict verdict = judge(setpoint);
  if (verdict == SetpointVerdict::kTooOld || verdict == SetpointVerdict::kTooEarly) {
    mistimed_ += kMistimed;
    if (mistimed_ > kMaxMistimed) since_setpoint_us_ = options_.setpoint_timeout_us + 1;  // as if none came any more
  }
  if (verdict != SetpointVerdict::kAccepted) return verdict;
  if (options_.shape == BridgeOptions::Shape::kLinear) {
    if (!interpolator_.add(setpoint)) return SetpointVerdict::kNotNewer;
  } else {
    if (num_waiting_ == waiting_.size()) {
      std::move(waiting_.begin() + 1, waiting_.end(), waiting_.begin());
      --num_waiting_;
    }
    waiting_[num_waiting_++] = setpoint;
  }
  newest_ = setpoint;
  if (mistimed_ <= kMaxMistimed) {
    since_setpoint_us_ = 0;
    mistimed_ = std::max(mistimed_ - 1, 0);
  }
  return verdict;
}

/// Whether a set-point's velocity, rad/s or m/s, is far beyond the limits.
bool Bridge::is_too_fast(const JointVector& velocity) const {
  return (velocity.cwiseAbs() - kImpliedSpeed * generator_.limits().velocity).maxCoeff() > 0;
}

/// Judges a set-point of a running motion.
SetpointVerdict Bridge::judge(const Setpoint& setpoint) const {
  if (setpoint.run != run_) return SetpointVerdict::kOtherRun;
  if (setpoint.sequence <= newest_.sequence || setpoint.utime <= newest_.utime) return SetpointVerdict::kNotNewer;
  if (setpoint.utime < *next_tick_ - options_.max_setpoint_age_us) return SetpointVerdict::kTooOld;
  if (setpoint.utime > *next_tick_ + options_.max_setpoint_lead_us) return SetpointVerdict::kTooEarly;
  const double seconds = static_cast<double>(setpoint.utime - newest_.utime) * kMicro;
  const bool fast = is_too_fast((setpoint.theta - newest_.theta) / seconds) || is_too_fast(setpoint.velocity);
  return fast ? SetpointVerdict::kTooFast : SetpointVerdict::kAccepted;
}

/// In the state armed: follows the sender of this set-point from now on, if the robot stands near it.
SetpointVerdict Bridge::start_following(const Setpoint& setpoint, bool& restarted) {
  if (!commands_robot()) return SetpointVerdict::kNotReady;
  if (!measured_since_gap_ || !monitor_.stands()) return SetpointVerdict::kFarFromRobot;
  const JointVector from = next_tick_ ? generator_.state().position : monitor_.newest().theta;
  const bool near = (setpoint.theta - from).cwiseAbs().maxCoeff() <= options_.max_start_distance;
  // The same sender after an interruption: slowly, which the linear shape cannot.
  const bool resumes = next_tick_ && setpoint.run == run_ && options_.shape == BridgeOptions::Shape::kSmooth;
  if (chain_.limit_excess(setpoint.theta) > options_.max_start_distance) return SetpointVerdict::kInvalid;
  if (is_too_fast(setpoint.velocity)) return SetpointVerdict::kTooFast;
  if (!near && !resumes) return SetpointVerdict::kFarFromRobot;
  if (!near) {
    if (!far_since_) far_since_ = *next_tick_;
    if (*next_tick_ - *far_since_ < kAskFirst * options_.setpoint_period_us) return SetpointVerdict::kFarFromRobot;
  }
  far_since_.reset();
  restarted = true;
  if (!next_tick_) {
    generator_.rest_at(from);
    monitor_.rest_at(from);
    robot_run_ = monitor_.run();
  }
  next_tick_ = setpoint.utime;
  interpolator_.reset(from);
  interpolator_.add(setpoint);
  run_ = setpoint.run;
  newest_ = waiting_[0] = setpoint;
  num_waiting_ = 1;
  goal_ = {};
  velocity_ = JointVector::Zero(chain_.size());
  since_setpoint_us_ = 0;
  mistimed_ = 0;
  approaching_ = !near;
  pace_ = paused_ ? 0 : approaching_ ? std::min(speed_, kApproachSpeed) : speed_;
  path_rate_ = pace_;
  setpoint_rate_ = approaching_ ? 0 : pace_;
  state_ = BridgeState::kRunning;
  cause_ = "";
  return SetpointVerdict::kAccepted;
}

Command Bridge::tick() {
  const int64_t now = *next_tick_;
  const JointVector before = generator_.state().position;
  step();
  Command command;
  command.utime = now;
  command.setpoint_sequence = goal_.sequence;
  command.holding = state_ != BridgeState::kRunning || coasted_ || goal_.sequence < 0;
  command.limited = path_rate_ < pace_ && !command.holding;
  command.theta = generator_.state().position;
  command.velocity = options_.shape == BridgeOptions::Shape::kLinear
                         ? ((command.theta - before) / (static_cast<double>(options_.period_us) * kMicro)).eval()
                         : generator_.state().velocity;
  // At rest, a bridge that is disabled or in a fault ends its stream: the robot then holds its position by itself.
  if (generator_.at_rest() && (state_ == BridgeState::kFault || (state_ == BridgeState::kStopping && !enabled_))) {
    next_tick_.reset();
    measured_since_gap_ = false;
    if (state_ == BridgeState::kStopping) {
      state_ = BridgeState::kIdle;
      cause_ = "";
    }
  }
  return command;
}

void Bridge::skip(int64_t periods) {
  if (!next_tick_) return;
  if (periods <= kBridgedGap) {
    for (int64_t k = 0; k < periods && next_tick_; ++k) step();
    return;
  }
  // The robot stops by itself: begin again from rest, where the last command was.
  *next_tick_ += periods * options_.period_us;
  const JointVector position = generator_.state().position;
  generator_.rest_at(position);
  replans_ = true;
  if (periods * options_.period_us <= options_.robot_timeout_us) return;
  // It has stopped: look where it is before the motion goes on.
  monitor_.rest_at(position);
  measured_since_gap_ = false;
  num_waiting_ = 0;
  path_rate_ = setpoint_rate_ = 0;
  if (state_ == BridgeState::kRunning || state_ == BridgeState::kStopping) {
    state_ = enabled_ ? BridgeState::kArmed : BridgeState::kStopping;
    if (enabled_) cause_ = "";
  }
}

/// One period without its command.
void Bridge::step() {
  watch_robot();
  if (state_ == BridgeState::kRunning) follow();
  if (options_.shape == BridgeOptions::Shape::kSmooth) generator_.advance();
  monitor_.commanded(generator_.state().position);
  *next_tick_ += options_.period_us;
  since_setpoint_us_ += options_.period_us;
  if (state_ == BridgeState::kRunning && since_setpoint_us_ > options_.setpoint_timeout_us && generator_.at_rest())
    state_ = BridgeState::kArmed;
}

void Bridge::watch_robot() {
  if (state_ == BridgeState::kFault) return;
  if (const char* fault = monitor_.fault()) return fail(fault);
  if (state_ == BridgeState::kRunning && monitor_.late()) return decelerate("no ROBOT_STATE");
  // Resumes from rest, as after a pause.
  if (state_ == BridgeState::kStopping && enabled_ && !monitor_.late() && generator_.at_rest()) {
    state_ = BridgeState::kArmed;
    cause_ = "";
  }
}

void Bridge::fail(const char* cause) {
  joint_of_fault_ = monitor_.furthest_joint();
  decelerate(cause);
  state_ = BridgeState::kFault;
}

void Bridge::decelerate(const char* cause) {
  far_since_.reset();
  if (options_.shape == BridgeOptions::Shape::kLinear) {
    generator_.rest_at(generator_.state().position);
  } else {
    generator_.stop();
  }
  num_waiting_ = 0;
  path_rate_ = setpoint_rate_ = 0;
  cause_ = cause;
  state_ = BridgeState::kStopping;
}

/// Starts the segment to the newest set-point that is due.
void Bridge::follow() {
  if (options_.shape == BridgeOptions::Shape::kLinear) {
    bool limited = false;
    const JointVector position = guard_.next(generator_.state().position, interpolator_.at(*next_tick_), limited);
    generator_.rest_at(position);
    goal_.sequence = interpolator_.sequence();
    coasted_ = interpolator_.holding();
    setpoint_rate_ = paused_ || speed_ < kMinSpeed ? 0 : std::min(speed_, monitor_.speed_factor());
    path_rate_ = limited ? 0.5 : 1;
    return;
  }
  const double wanted = paused_ ? 0 : std::min({speed_, monitor_.speed_factor(), approaching_ ? kApproachSpeed : 1.0});
  const double speed = pace_ = std::max(wanted, pace_ - kSlowing * static_cast<double>(options_.period_us) * kMicro);
  // The sender waits until the robot is near: at the robot's own rate, it would stay as far ahead.
  setpoint_rate_ = speed < kMinSpeed || approaching_ ? 0 : speed;
  if (since_setpoint_us_ > options_.setpoint_timeout_us)
    num_waiting_ = 0;  // the controller is gone: also ends a long segment
  if (speed < kMinSpeed || since_setpoint_us_ > options_.setpoint_timeout_us) {
    path_rate_ = 0;
    return generator_.stop();
  }
  const int64_t begin = *next_tick_ - options_.period_us;  // time of generator_.state()
  std::optional<Setpoint> due;
  while (num_waiting_ > 0 && waiting_[0].utime + options_.delay_us <= begin) {
    due = waiting_[0];
    std::move(waiting_.begin() + 1, waiting_.begin() + static_cast<std::ptrdiff_t>(num_waiting_), waiting_.begin());
    --num_waiting_;
  }
  if (due || (replans_ && goal_.sequence >= 0)) {
    move_to(due ? *due : goal_, speed);
    replans_ = false;
  } else if (generator_.finished() && !generator_.at_rest()) {
    // A set-point is missing: continue for one period at the velocity of the last, then stop.
    const double period = static_cast<double>(options_.setpoint_period_us) * kMicro;
    MotionState onwards = generator_.state();
    onwards.position += period * onwards.velocity;
    onwards.acceleration.setZero();
    if (coasted_ || generator_.move_to(onwards, period) < 1) generator_.stop();
    coasted_ = true;
  }
}

void Bridge::move_to(const Setpoint& goal, double speed) {
  const double period = static_cast<double>(options_.setpoint_period_us) * kMicro;
  const int64_t begin = *next_tick_ - options_.period_us;
  // A set-point is reached one period after its segment begins, at the latest possible punctual start.
  const double left =
      static_cast<double>(goal.utime + options_.delay_us + options_.setpoint_period_us - begin) * kMicro;
  double duration = std::clamp(left, period / 2, period) / speed;
  if (approaching_) {  // from rest to rest, a quintic's peak speed is 1.875 times its mean
    const JointVector distance = (goal.theta - generator_.state().position).cwiseAbs();
    duration = std::max(duration, 1.875 * distance.cwiseQuotient(speed * generator_.limits().velocity).maxCoeff());
  }
  MotionState end{goal.theta, speed * goal.velocity, JointVector::Zero(goal.theta.size())};
  const bool follows =
      goal_.sequence >= 0 && goal.utime > goal_.utime && goal.utime - goal_.utime <= 2 * options_.setpoint_period_us;
  if (follows) {
    const double seconds = static_cast<double>(goal.utime - goal_.utime) * kMicro;
    end.acceleration = speed * speed * (goal.velocity - goal_.velocity) / seconds;
  }
  const double rate = generator_.move_to(end, duration);
  if (rate == 0 && generator_.finished()) generator_.stop();
  path_rate_ = rate * speed;
  goal_ = goal;
  coasted_ = false;
  if ((goal.theta - generator_.state().position).cwiseAbs().maxCoeff() <= options_.max_start_distance)
    approaching_ = false;
}

}  // namespace multireach::robot_bridge
