#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace multireach::controller {

/// The largest velocity towards a limit that a joint may have when it is `distance` away from it, per step, so that it
/// never passes the limit and can always brake in time: the bound "barrier" of docs/guarantees.md.
///
/// With the safe speed f(s) = rate * s up to s = a / rate^2 and f(s) = sqrt(2 a s - a^2 / rate^2) beyond (its
/// continuation with the same slope; a is `acceleration`), this is the largest v with v <= f(distance - v). Outside the
/// limit (distance < 0) it is the velocity at which the joint must come back: the same, mirrored, so that it does not
/// come back faster than it can stop.
struct BarrierRate {
  explicit BarrierRate(double per_step) : rate(per_step), slope(per_step / (1 + per_step)) {}
  double rate, slope;
};

inline double barrier(double distance, const BarrierRate& rate, double acceleration) {
  if (std::isinf(distance)) return distance;
  const double linear = rate.slope * distance;
  if (!(std::abs(linear) * rate.rate > acceleration)) return linear;
  const double bend = acceleration / rate.rate;  // f at the bend
  const double root = std::sqrt(acceleration * acceleration + 2 * acceleration * std::abs(distance) - bend * bend);
  return std::copysign(root - acceleration, distance);
}

/// What a joint's velocity may be in the next step, all per step.
struct VelocityRange {
  double lower, upper;
};

/// The velocities that keep a joint inside its position limits [lower, upper], its speed and its acceleration, for
/// ever: see docs/guarantees.md. Never empty. A joint that was brought outside a limit comes back, at most at
/// `largest_speed`. Limits, speed and acceleration may be infinite.
inline VelocityRange velocity_range(double position, double velocity, double lower, double upper, double largest_speed,
                                    double acceleration, const BarrierRate& rate) {
  double high = std::min(barrier(upper - position, rate, acceleration), velocity + acceleration);
  double low = std::max(-barrier(position - lower, rate, acceleration), velocity - acceleration);
  // What was pushed outside or too fast (never by this controller itself) brakes as hard as it may.
  high = std::max(high, velocity - acceleration);
  low = std::min(low, velocity + acceleration);
  high = std::clamp(high, -largest_speed, largest_speed);
  low = std::clamp(low, -largest_speed, largest_speed);
  return {std::min(low, high), std::max(low, high)};
}

}  // namespace multireach::controller
