#include "robot_bridge/bridge.hpp"

#include <cstdlib>
#include <stdexcept>

namespace multireach::robot_bridge {
namespace {

constexpr double kAbsurd = 1e6;           // rad or m: no joint has such a position; larger values could overflow
constexpr int64_t kOtherClock = 1000000;  // us: a set-point further than this from the bridge's time has another clock

const BridgeOptions& checked(const BridgeOptions& options) {
  if (options.period_us <= 0 || options.setpoint_period_us <= 0)
    throw std::invalid_argument("the bridge's periods must be positive");
  if (options.delay_us < 0 || options.delay_us > 3 * options.setpoint_period_us) {
    throw std::invalid_argument("the bridge's delay must be from zero to three periods of the set-points");
  }
  if (!(options.speed_where_unlimited > 0))
    throw std::invalid_argument("the speed of joints without a limit must be positive");
  return options;
}

}  // namespace

Bridge::Bridge(const Chain& chain, const BridgeOptions& options)
    : chain_(chain),
      options_(checked(options)),
      interpolator_(options.setpoint_period_us, options.delay_us),
      guard_(chain, static_cast<double>(options.period_us) * 1e-6, options.speed_where_unlimited) {}

bool Bridge::sensible(const JointVector& theta) const {
  return theta.size() == chain_.size() && theta.allFinite() && theta.cwiseAbs().maxCoeff() < kAbsurd;
}

bool Bridge::measured(const JointVector& theta) {
  if (!sensible(theta)) return false;
  if (!next_tick_) {
    position_ = theta;
    interpolator_.reset(theta);
  }
  return true;
}

bool Bridge::setpoint(const Setpoint& setpoint) {
  if (!position_ || !sensible(setpoint.theta)) return false;
  if (!next_tick_ || std::abs(setpoint.utime - *next_tick_) > kOtherClock) {
    interpolator_.reset(*position_);
    next_tick_ = setpoint.utime;
  }
  return interpolator_.add(setpoint);
}

Command Bridge::tick() {
  Command command;
  command.utime = *next_tick_;
  *next_tick_ += options_.period_us;
  const JointVector wanted = interpolator_.at(command.utime);
  command.theta = guard_.next(*position_, wanted, command.limited);
  command.velocity = (command.theta - *position_) * (1e6 / static_cast<double>(options_.period_us));
  command.holding = interpolator_.holding();
  command.setpoint_sequence = interpolator_.sequence();
  position_ = command.theta;
  return command;
}

}  // namespace multireach::robot_bridge
