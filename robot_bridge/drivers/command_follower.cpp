#include "robot_bridge/drivers/command_follower.hpp"

#include <algorithm>

namespace multireach::drivers {
namespace {

using robot_bridge::MotionState;

constexpr int64_t kSettles = 500000;  // us
constexpr int64_t kNext = 10000;      // us: a longer step in the commands' time tells nothing of their acceleration

}  // namespace

void CommandFollower::forget() {
  sent_.reset();
  ramp_.reset();
  blend_.reset();
  joined_.reset();
  stopping_ = false;
  last_.position.resize(0);
}

const MotionState& CommandFollower::command(const JointVector& position, const JointVector& velocity, int64_t utime,
                                            const JointVector& arm, int64_t now_us) {
  const int64_t step_us = sent_ ? std::clamp<int64_t>(utime - utime_, 0, kNext) : 0;
  MotionState state{position, velocity, JointVector::Zero(position.size())};
  if (step_us > 0 && step_us < kNext) {
    state.acceleration =
        ((velocity - velocity_) / (static_cast<double>(step_us) * 1e-6)).cwiseMax(-limits_.acceleration);
    state.acceleration = state.acceleration.cwiseMin(limits_.acceleration).eval();
  }
  // Several commands may arrive at once after a pause: the blend begins with the last of them.
  if (joined_ && now_us != joined_us_) joined_.reset();
  if (!sent_) {
    // Shortly after a stop the arm still approaches the position that was sent last.
    const bool holds = last_.position.size() > 0 && now_us - now_us_ < kSettles;
    joined_ = MotionState::at_rest(holds ? last_.position : arm);
  } else if (ramp_) {
    joined_ = ramp_->at(static_cast<double>(now_us - now_us_) * 1e-6);
    ramp_.reset();
  }
  if (joined_) {
    joined_us_ = now_us;
    blend_.emplace(limits_, MotionState{joined_->position - state.position, joined_->velocity - state.velocity, {}});
    blended_s_ = 0;
    // The way to commands at a limit may not pass it; an arm beyond one comes back.
    lowest_ = limits_.lower.cwiseMin(joined_->position);
    highest_ = limits_.upper.cwiseMax(joined_->position);
  } else if (blend_) {
    blended_s_ += static_cast<double>(step_us) * 1e-6;
  }
  if (blend_) {
    blend_->apply(blended_s_, state);
    state.position = state.position.cwiseMax(lowest_).cwiseMin(highest_).eval();
  }
  if (blend_ && blend_->over(blended_s_)) blend_.reset();
  velocity_ = velocity;
  utime_ = utime;
  now_us_ = now_us;
  sent_ = state;
  return *sent_;
}

const MotionState* CommandFollower::missing(int64_t now_us, int64_t& utime) {
  const int64_t elapsed = now_us - now_us_;
  if (!sent_ || elapsed <= 0) return nullptr;
  if (!ramp_) ramp_.emplace(limits_, *sent_);
  stopping_ = stopping_ || elapsed > timeout_us_;
  utime = utime_ + elapsed;
  sent_ = ramp_->at(static_cast<double>(elapsed) * 1e-6);
  if (stopping_ && ramp_->at_rest()) {
    const MotionState end = *sent_;
    forget();
    last_ = end;
    return &last_;
  }
  return &*sent_;
}

}  // namespace multireach::drivers
