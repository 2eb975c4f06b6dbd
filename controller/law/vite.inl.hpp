// Included inside a namespace; see numeric/sine_cosine.inl.hpp. `Vector` is an Eigen vector, a double, or Lanes.

/// The velocity of the attractor of Eq. (3) in the next step, by Euler integration with step 1: Eqs. (19), (20) for
/// joint angles and (21), (22) for the hand. All vectors have the same size; velocities are per step.
template <class Vector>
inline Vector vite_velocity(double alpha, double beta, const Vector& position, const Vector& velocity,
                            const Vector& target) {
  return velocity + alpha * (-velocity + beta * (target - position));
}
