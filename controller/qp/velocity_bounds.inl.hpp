// Text for the inside of a namespace; see numeric/sine_cosine.inl.hpp. `Scalar` is double, or the Lanes of several
// arms.

/// The largest velocity towards a limit that a joint may have when it is `distance` away from it, per step, so that it
/// never passes the limit and can always brake in time: the bound "barrier" of docs/guarantees.md.
///
/// With the safe speed f(s) = rate * s up to s = a / rate^2 and f(s) = sqrt(2 a s - a^2 / rate^2) beyond (its
/// continuation with the same slope; a is `acceleration`), this is the largest v with v <= f(distance - v). Outside the
/// limit (distance < 0) it is the velocity at which the joint must come back: the same, mirrored, so that it does not
/// come back faster than it can stop.
template <class Scalar>
inline Scalar barrier(Scalar distance, const BarrierRate& rate, double acceleration) {
  const Scalar linear = rate.slope * distance;
  if (acceleration == std::numeric_limits<double>::infinity()) return linear;
  const auto curved = absolute(linear) * rate.rate > acceleration;
  if (!any(curved)) return linear;
  const double bend = acceleration / rate.rate;  // f at the bend
  const Scalar root = square_root(acceleration * acceleration + 2 * acceleration * absolute(distance) - bend * bend);
  return where(curved, with_sign_of(root - acceleration, distance), linear);
}

/// What a joint's velocity may be in the next step.
template <class Scalar>
struct VelocityBounds {
  Scalar lower, upper;
};

/// The velocities that keep a joint inside its position limits [lower, upper], its speed and its acceleration, for
/// ever: see docs/guarantees.md. Never empty. A joint that was brought outside a limit comes back, at most at
/// `max_speed`. All per step; limits, speed and acceleration may be infinite.
template <class Scalar>
inline VelocityBounds<Scalar> velocity_bounds(Scalar position, Scalar velocity, double lower, double upper,
                                              double max_speed, double acceleration, const BarrierRate& rate) {
  Scalar high = barrier(upper - position, rate, acceleration), low = -barrier(position - lower, rate, acceleration);
  if (acceleration < std::numeric_limits<double>::infinity()) {
    // What was pushed outside or too fast (never by this controller itself) brakes as hard as it may.
    high = greater(lesser(high, velocity + acceleration), velocity - acceleration);
    low = lesser(greater(low, velocity - acceleration), velocity + acceleration);
  }
  high = clamped(high, -max_speed, max_speed);
  low = clamped(low, -max_speed, max_speed);
  return {lesser(low, high), greater(low, high)};
}
