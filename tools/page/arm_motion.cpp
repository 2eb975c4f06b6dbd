#include "tools/page/arm_motion.hpp"

#include <algorithm>
#include <multireach/joint_setpoint_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach {

ArmMotion::ArmMotion(const Chain& chain, int64_t run) : chain_(chain), run_(run) {}

void ArmMotion::robot(const JointVector& theta, const JointVector& velocity, bool simulated) {
  simulated_ = simulated;
  theta_ = theta;
  velocity_ = velocity;
}

void ArmMotion::bridge(const bridge_state_t& state) {
  bridge_ = state;
}

void ArmMotion::go_to(const JointVector& goal) {
  if (!theta_) return;
  // From the last set-point where there is one: the robot follows it, but may sag a little.
  from_ = goal_ && elapsed_s_ >= duration_s_ ? *goal_ : *theta_;
  goal_ = goal;
  elapsed_s_ = 0;
  constexpr double kPeak = 1.875;  // of the speed of a minimum-jerk motion, relative to its mean
  duration_s_ = 0.5;
  for (int i = 0; i < chain_.size(); ++i) {
    constexpr double kFastestSimulated = 1.5;
    const double fastest = std::min(simulated_ ? kFastestSimulated : kFastest, kShareOfLimit * chain_.velocity()[i]);
    duration_s_ = std::max(duration_s_, kPeak * std::abs(goal[i] - from_[i]) / fastest);
  }
}

bool ArmMotion::arrived() const {
  constexpr double kAtRest = 0.02;  // rad/s or m/s
  return goal_ && theta_ && elapsed_s_ >= duration_s_ && (*theta_ - *goal_).cwiseAbs().maxCoeff() < kNear &&
         velocity_->cwiseAbs().maxCoeff() < kAtRest;
}

std::string ArmMotion::obstacle() const {
  if (!theta_) return "no ROBOT_STATE arrives: start the robot";
  if (!bridge_) return "the bridge does not answer: is it running?";
  if (bridge_->state == bridge_state_t::IDLE)
    return "the robot is disabled: look that nobody is near it, then enable it (E)";
  if (bridge_->state == bridge_state_t::FAULT) return "the bridge is in a fault (" + bridge_->cause + "): reset it (R)";
  if (bridge_->setpoint_rate == 0 && bridge_->path_rate == 0 && bridge_->state == bridge_state_t::RUNNING)
    return "paused: continue with C";
  return "";
}

void ArmMotion::tick(int64_t now_us, Outbox& out) {
  constexpr int64_t kMostLate = 400000;  // us
  if (!goal_ || now_us - sent_us_ < kPeriod) return;
  const bool running = bridge_ && bridge_->state == bridge_state_t::RUNNING;
  // Until the bridge follows, the motion begins from where the robot is.
  if (!running && (!bridge_ || bridge_->state != bridge_state_t::STOPPING)) {
    elapsed_s_ = 0;
    go_to(*goal_);
  }
  const bool late = now_us - sent_us_ > kMostLate;
  sent_us_ = now_us;
  if (!running && (!bridge_ || bridge_->state != bridge_state_t::ARMED)) return;
  if (running && !late) elapsed_s_ += 1e-6 * kPeriod * bridge_->setpoint_rate;
  const double s = std::min(elapsed_s_ / duration_s_, 1.0);
  // The minimum-jerk profile.
  const double way = s * s * s * (10 + s * (-15 + 6 * s)), speed = 30 * s * s * (1 + s * (-2 + s)) / duration_s_;
  joint_setpoint_t setpoint{};
  setpoint.utime = now_us;
  setpoint.sequence = sequence_++;
  setpoint.run = run_;
  setpoint.target_sequence = setpoint.robot_state_sequence = setpoint.obstacles_sequence = -1;
  setpoint.num_joints = chain_.size();
  setpoint.joint_name = joint_names(chain_);
  setpoint.joint_position = to_field(JointVector(from_ + way * (*goal_ - from_)));
  setpoint.joint_velocity = to_field(JointVector(speed * (*goal_ - from_)));
  if (auto bytes = encode(setpoint)) out.push_back({channel::kJointSetpoint, std::move(*bytes)});
}

}  // namespace multireach
