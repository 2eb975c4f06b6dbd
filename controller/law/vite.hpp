#pragma once

namespace multireach::controller {

/// Gains of the spring-damper attractor r'' = alpha (-r' + beta (r_T - r)), Eq. (3), per integration step. It does not
/// overshoot when alpha >= 4 beta (Sect. 2.2.1); the paper's own values, the defaults here, overshoot by 1.2 %.
struct ViteGains {
  double alpha = 0.08;
  double beta = 0.03;
};

#include "controller/law/vite.inl.hpp"

/// Overload for ViteGains.
template <class Vector>
Vector vite_velocity(const ViteGains& gains, const Vector& position, const Vector& velocity, const Vector& target) {
  return vite_velocity(gains.alpha, gains.beta, position, velocity, target);
}

}  // namespace multireach::controller
