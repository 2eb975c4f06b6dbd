#include "robot_bridge/drivers/command_follower.hpp"

#include <algorithm>

namespace multireach::drivers {
namespace {

using robot_bridge::MotionState;

constexpr int64_t kSettles = 500000;     // us
constexpr int64_t kNext = 10000;         // us: a longer step in the commands' time tells nothing of their acceleration
constexpr int64_t kExtrapolated = 3000;  // us without a command
constexpr int64_t kMostLeap = 2000;      // us, in a millisecond: more than where a command is late by one or two

}  // namespace

void CommandFollower::forget() {
  sent_.reset();
  ramp_.reset();
  transitions_.clear();
  joined_.reset();
  missed_ = stopping_ = false;
  last_.position.resize(0);
}

/// The arm is, or soon will be, at rest there.
void CommandFollower::rest_at(const JointVector& position, int64_t now_us) {
  const MotionState rest = MotionState::at_rest(position);
  forget();
  last_ = rest;
  now_us_ = now_us;
}

/// Whether the commands' time has leapt forward since the last millisecond, as where many come that have waited, or
/// most of these were lost.
bool CommandFollower::leaps(int64_t utime, int64_t now_us) {
  if (now_us != lead_at_us_) {
    lead_before_us_ = lead_us_;
    lead_at_us_ = now_us;
  }
  lead_us_ = utime - now_us;
  return sent_ && lead_us_ - lead_before_us_ > kMostLeap;
}

void CommandFollower::add_transitions(double ahead_s, MotionState& state) const {
  for (const Transition& each : transitions_) each.blend.apply(each.elapsed_s + ahead_s, state);
}

/// The way to commands at a limit may not pass it; an arm beyond one comes back.
void CommandFollower::keep_positions_allowed(MotionState& state) const {
  const JointVector &lowest = transitions_.empty() ? limits_.lower : lowest_,
                    &highest = transitions_.empty() ? limits_.upper : highest_;
  for (int i = 0; i < state.position.size(); ++i) {
    const double allowed = std::clamp(state.position[i], lowest[i], highest[i]);
    if ((state.position[i] - allowed) * state.velocity[i] > 0) state.velocity[i] = state.acceleration[i] = 0;
    state.position[i] = allowed;
  }
}

/// The last command goes on with its acceleration, as far as the speed limits allow.
MotionState CommandFollower::extrapolated(int64_t elapsed_us) const {
  const double seconds = static_cast<double>(elapsed_us) * 1e-6;
  const JointVector fastest = limits_.velocity.cwiseMax(command_.velocity.cwiseAbs());
  MotionState state = command_;
  state.velocity = (command_.velocity + seconds * command_.acceleration).cwiseMax(-fastest).cwiseMin(fastest);
  state.position = command_.position + seconds / 2 * (command_.velocity + state.velocity);
  add_transitions(seconds, state);
  return state;
}

/// What is sent without a command for so long.
MotionState CommandFollower::between_commands(int64_t elapsed_us) {
  const int64_t ramp_us = elapsed_us - kExtrapolated;
  if (ramp_us > 0 && !ramp_) ramp_.emplace(limits_, extrapolated(kExtrapolated));
  MotionState state = ramp_ ? ramp_->at(static_cast<double>(ramp_us) * 1e-6) : extrapolated(elapsed_us);
  keep_positions_allowed(state);
  return state;
}

/// From what was sent to this command.
void CommandFollower::begin_transition(MotionState& state) {
  if (transitions_.empty()) {
    lowest_ = limits_.lower;
    highest_ = limits_.upper;
  }
  lowest_ = lowest_.cwiseMin(joined_->position).eval();
  highest_ = highest_.cwiseMax(joined_->position).eval();
  if (transitions_.size() == kMostTransitions) transitions_.pop_back();  // its rest becomes part of the new one
  MotionState remaining = state;
  add_transitions(0, remaining);
  transitions_.push_back(
      {JoinBlend(limits_, {joined_->position - remaining.position, joined_->velocity - remaining.velocity, {}}), 0});
}

const MotionState& CommandFollower::command(const JointVector& position, const JointVector& velocity, int64_t utime,
                                            const JointVector& arm, int64_t now_us) {
  const bool leap = leaps(utime, now_us);
  const int64_t step_us = sent_ ? std::clamp<int64_t>(utime - utime_, 0, kNext) : 0;
  const double step_s = static_cast<double>(step_us) * 1e-6;
  MotionState state{position, velocity, JointVector::Zero(position.size())};
  if (step_us > 0 && step_us < kNext) {
    state.acceleration =
        ((velocity - command_.velocity) / step_s).cwiseMax(-limits_.acceleration).cwiseMin(limits_.acceleration);
  }
  // Several commands may arrive at once after a pause: the transition begins with the last of them.
  if (joined_ && now_us != joined_us_) joined_.reset();
  if (joined_) {
    transitions_.pop_back();
  } else if (!sent_) {
    // Shortly after a stop the arm still approaches the position that was sent last.
    const bool holds = last_.position.size() > 0 && now_us - now_us_ < kSettles;
    joined_ = MotionState::at_rest(holds ? last_.position : arm);
  } else if (missed_ || leap) {
    joined_ = between_commands(now_us - now_us_);
  }
  joined_us_ = now_us;
  for (Transition& each : transitions_) each.elapsed_s += step_s;
  std::erase_if(transitions_, [](const Transition& each) { return each.blend.over(each.elapsed_s); });
  command_ = state;
  if (joined_) begin_transition(state);
  add_transitions(0, state);
  keep_positions_allowed(state);
  ramp_.reset();
  missed_ = false;
  utime_ = utime;
  now_us_ = now_us;
  sent_ = state;
  return *sent_;
}

const MotionState* CommandFollower::missing(int64_t now_us, int64_t& utime) {
  const int64_t elapsed = now_us - now_us_;
  if (!sent_ || elapsed <= 0) return nullptr;
  missed_ = true;
  stopping_ = stopping_ || elapsed > timeout_us_;
  utime = utime_ + elapsed;
  sent_ = between_commands(elapsed);
  if (stopping_ && ramp_ && ramp_->at_rest()) {
    rest_at(sent_->position, now_us_);
    return &last_;
  }
  return &*sent_;
}

}  // namespace multireach::drivers
