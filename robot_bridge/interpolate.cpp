#include "robot_bridge/interpolate.hpp"

#include <algorithm>

namespace multireach::robot_bridge {

void Interpolator::reset(const JointVector& theta) {
  num_waiting_ = 0;
  from_ = theta;
  to_ = {};
  to_.theta = theta;
  begin_us_ = last_us_ = 0;
  holding_ = true;
}

bool Interpolator::add(const Setpoint& setpoint) {
  const bool any = num_waiting_ > 0 || to_.sequence >= 0;
  const int64_t newest = num_waiting_ > 0 ? waiting_[num_waiting_ - 1].utime : to_.utime;
  if (any && setpoint.utime <= newest) return false;
  if (num_waiting_ == waiting_.size()) drop_first();
  waiting_[num_waiting_++] = setpoint;
  return true;
}

void Interpolator::drop_first() {
  std::move(waiting_.begin() + 1, waiting_.begin() + static_cast<std::ptrdiff_t>(num_waiting_), waiting_.begin());
  --num_waiting_;
}

JointVector Interpolator::at(int64_t utime) {
  const auto along = [&](int64_t time) -> JointVector {
    const double part = static_cast<double>(time - begin_us_) / static_cast<double>(period_us_);
    if (part >= 1) return to_.theta;
    return from_ + std::max(part, 0.0) * (to_.theta - from_);
  };
  while (num_waiting_ > 0 && waiting_[0].utime + delay_us_ <= utime) {
    // The segment of a punctual set-point starts at the set-point's time plus the delay; that of a late one starts now.
    const bool follows = to_.sequence >= 0 && waiting_[0].utime + delay_us_ > last_us_;
    const int64_t begin = follows ? waiting_[0].utime + delay_us_ : utime;
    from_ = along(begin);
    to_ = waiting_[0];
    begin_us_ = begin;
    drop_first();
  }
  last_us_ = utime;
  holding_ = to_.sequence < 0 || utime >= begin_us_ + period_us_;
  return along(utime);
}

}  // namespace multireach::robot_bridge
