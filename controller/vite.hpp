#pragma once

namespace multireach::controller {

/// Gains of the spring-damper attractor r'' = alpha (-r' + beta (r_T - r)), Eq. (3), per integration step. Without
/// overshoot when alpha >= 4 beta (Sect. 2.2.1); the paper's own values overshoot by 1.2 %.
struct ViteGains {
  double alpha = 0.08;
  double beta = 0.03;
};

/// The velocity that the attractor wants for the next step: Eqs. (19), (20) on joint angles and (21), (22) on the hand,
/// by Euler's rule with a step of 1. Arguments are vectors of one size; velocities are per step.
template <class Vector>
Vector vite_velocity(const ViteGains& gains, const Vector& position, const Vector& velocity, const Vector& target) {
  return velocity + gains.alpha * (-velocity + gains.beta * (target - position));
}

}  // namespace multireach::controller
