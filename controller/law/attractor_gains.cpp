#include "controller/law/attractor_gains.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::controller {
namespace {

// The error d = r_T - r and the velocity v of Eq. (3), v+ = (1 - alpha) v + alpha beta d, d+ = d - v+, have the
// characteristic polynomial (1 - alpha) - (2 - alpha - alpha beta) z + z^2. Hence z1 z2 = 1 - alpha and
// (1 - z1) (1 - z2) = alpha beta. The poles are given as rates: z = exp(-rate), per step.
struct Poles {
  double slow, fast;
};

ViteGains gains_of(const Poles& rates) {
  const double alpha = -std::expm1(-rates.slow - rates.fast);
  return {alpha, std::expm1(-rates.slow) * std::expm1(-rates.fast) / alpha};
}

Poles poles_of(const ViteGains& gains) {
  const auto [alpha, beta] = gains;
  const double middle = 1 - 0.5 * alpha * (1 + beta);
  const double apart = std::sqrt(std::max(0.0, 0.25 * alpha * (alpha * (1 + beta) * (1 + beta) - 4 * beta)));
  const double slow = middle + apart;
  return {-std::log(slow), std::log(slow) - std::log1p(-alpha)};
}

}  // namespace

ViteGains vite_gains(const AttractorMotion& motion, double steps_per_second) {
  const double ratio = motion.damping_ratio, per_step = motion.natural_frequency / steps_per_second;
  const double fast = ratio + std::sqrt(std::max(0.0, ratio * ratio - 1));
  return gains_of({per_step / fast, per_step * fast});
}

AttractorMotion attractor_motion(const ViteGains& gains, double steps_per_second) {
  const auto [slow, fast] = poles_of(gains);
  const double frequency = std::sqrt(slow * fast);
  return {frequency * steps_per_second, 0.5 * (slow + fast) / frequency};
}

ViteGains gains_at_rate(const ViteGains& gains, double from, double to) {
  if (from == to) return gains;
  const auto [slow, fast] = poles_of(gains);
  return gains_of({slow * from / to, fast * from / to});
}

}  // namespace multireach::controller
