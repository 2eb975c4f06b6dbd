// Included inside a namespace; see numeric/sine_cosine.inl.hpp. `Scalar` is double, or the Lanes of several arms.

/// The largest velocity (per step) towards a joint limit at `distance` from it, such that the joint never passes the
/// limit and can always brake in time: the "barrier" of docs/guarantees.md.
///
/// With the safe speed f(s) = rate * s up to s = a / rate^2 and f(s) = sqrt(2 a s - a^2 / rate^2) beyond (a
/// continuation with the same slope; a is `acceleration`), this is the largest v with v <= f(distance - v). Outside the
/// limit (distance < 0) it is the velocity at which the joint must return: the same function, mirrored, so that the
/// joint returns no faster than it can stop.
template <class Scalar>
inline Scalar barrier(Scalar distance, const BarrierRate& rate, double acceleration) {
  const Scalar linear = rate.slope * distance;
  if (acceleration == std::numeric_limits<double>::infinity()) return linear;
  const auto curved = absolute(linear) * rate.rate > acceleration;
  if (!any(curved)) return linear;
  const double bend = acceleration / rate.rate;  // f where the two parts meet
  const Scalar root = square_root(acceleration * acceleration + 2 * acceleration * absolute(distance) - bend * bend);
  return where(curved, with_sign_of(root - acceleration, distance), linear);
}

/// The range of a joint's velocity in the next step.
template <class Scalar>
struct VelocityBounds {
  Scalar lower, upper;
};

/// The velocities for which a joint can respect its position limits [lower, upper], its speed limit and its
/// acceleration limit in all later steps; see docs/guarantees.md. The range is never empty. A joint outside a limit
/// returns, at most at `max_speed`. All values are per step; limits, speed and acceleration may be infinite.
template <class Scalar>
inline VelocityBounds<Scalar> velocity_bounds(Scalar position, Scalar velocity, double lower, double upper,
                                              double max_speed, double acceleration, const BarrierRate& rate) {
  Scalar high = barrier(upper - position, rate, acceleration), low = -barrier(position - lower, rate, acceleration);
  if (acceleration < std::numeric_limits<double>::infinity()) {
    // A joint that starts outside a limit or too fast (this controller never brings it there) brakes at full
    // acceleration.
    high = greater(lesser(high, velocity + acceleration), velocity - acceleration);
    low = lesser(greater(low, velocity - acceleration), velocity + acceleration);
  }
  high = clamped(high, -max_speed, max_speed);
  low = clamped(low, -max_speed, max_speed);
  return {lesser(low, high), greater(low, high)};
}
