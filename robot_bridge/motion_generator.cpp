#include "robot_bridge/motion_generator.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::robot_bridge {
namespace {

constexpr double kGrowth = 1.15;    // of the duration from one attempt to the next
constexpr double kMaxSegment = 60;  // s

}  // namespace

void MotionGenerator::rest_at(const JointVector& position) {
  state_ = MotionState::at_rest(position);
  stopping_ = false;
  ticks_ = duration_ticks_ = 0;
}

double MotionGenerator::move_to(const MotionState& goal, double duration_s) {
  MotionState end = goal;
  end.position = goal.position.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
  const auto whole = [](double ticks) { return std::max<int64_t>(1, std::llround(std::ceil(ticks - 1e-6))); };
  const int64_t shortest = whole(duration_s / period_s_);
  const auto longest = static_cast<int64_t>(std::max(kMaxSegment, 2 * duration_s) / period_s_);
  for (int64_t ticks = shortest; ticks < longest; ticks = whole(static_cast<double>(ticks) * kGrowth)) {
    const double duration = static_cast<double>(ticks) * period_s_;
    const double rate = static_cast<double>(shortest) / static_cast<double>(ticks);
    end.velocity = rate * goal.velocity;
    end.acceleration = rate * rate * goal.acceleration;
    const QuinticSegment segment(state_, end, duration);
    if (!segment.keeps(limits_, period_s_)) continue;
    segment_ = segment;
    stopping_ = false;
    ticks_ = 0;
    duration_ticks_ = ticks;
    return rate;
  }
  return 0;
}

void MotionGenerator::stop() {
  if (stopping_ || at_rest()) return;
  double longest = 0;
  for (int i = 0; i < state_.position.size(); ++i) {
    bool feasible = false;
    StopProfile& stop = stops_[static_cast<size_t>(i)];
    stop = stop_profile(limits_, i, state_.position[i], state_.velocity[i], state_.acceleration[i], feasible);
    longest = std::max(longest, stop.duration_s);
  }
  stopping_ = true;
  ticks_ = 0;
  duration_ticks_ = std::llround(std::ceil(longest / period_s_));
}

void MotionGenerator::advance() {
  if (at_rest()) return;
  ++ticks_;
  const double time = static_cast<double>(ticks_) * period_s_;
  if (!stopping_) return segment_.at(time, state_);
  for (int i = 0; i < state_.position.size(); ++i) {
    stops_[static_cast<size_t>(i)].at(time, state_.position[i], state_.velocity[i], state_.acceleration[i]);
  }
}

}  // namespace multireach::robot_bridge
