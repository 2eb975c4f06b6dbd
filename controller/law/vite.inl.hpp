// Text for the inside of a namespace; see numeric/sine_cosine.inl.hpp. A `Vector` is an Eigen vector, a double, or
// Lanes.

/// The velocity that the attractor of Eq. (3) wants for the next step: Eqs. (19), (20) on joint angles and (21), (22)
/// on the hand, by Euler's rule with a step of 1. Arguments are vectors of one size; velocities are per step.
template <class Vector>
inline Vector vite_velocity(double alpha, double beta, const Vector& position, const Vector& velocity,
                            const Vector& target) {
  return velocity + alpha * (-velocity + beta * (target - position));
}
