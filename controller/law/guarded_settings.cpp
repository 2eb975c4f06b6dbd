#include "controller/law/guarded_settings.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "controller/law/guarded_law.hpp"
#include "controller/task/joint_weights.hpp"
#include "kinematics/default_limits.hpp"

namespace multireach::controller {
namespace {

void require(bool sensible, const char* sentence) {
  if (!sensible) throw std::invalid_argument(sentence);
}
bool positive(double value) {
  return std::isfinite(value) && value > 0;
}

/// The gains of both attractors per integration step.
ViteGains gains_of(const GuardedParameters& parameters) {
  if (parameters.attractor) {
    const auto [frequency, ratio] = *parameters.attractor;
    require(positive(frequency) && frequency <= GuardedParameters::kMaxNaturalFrequency,
            "the attractors' natural frequency must be positive, and at most 1000 rad/s");
    require(ratio >= 1 && ratio <= GuardedParameters::kMaxDampingRatio,
            "the attractors' damping ratio must be in [1, 100]: below 1 they would overshoot");
    return vite_gains(*parameters.attractor, parameters.steps_per_second);
  }
  const auto [alpha, beta] = parameters.gains;
  require(alpha > 0 && alpha <= 1 && beta > 0 && beta < 1, "alpha must be in (0, 1], beta in (0, 1)");
  require(alpha * (1 - beta) * (1 - beta) >= 4 * beta * (1 - alpha),
          "alpha is too small for beta: the law needs alpha (1 - beta)^2 >= 4 beta (1 - alpha), about alpha >= 4 beta, "
          "so that the joints' attractor does not overshoot");
  return gains_at_rate(parameters.gains, kReferenceRate, parameters.steps_per_second);
}

}  // namespace

IkOptions guarded_ik_options(const Chain& chain, const GuardedParameters& parameters) {
  IkOptions options = parameters.ik;
  options.joint_weights = joint_weights_of(chain, parameters.joint_weights);
  return options;
}

GuardedSettings guarded_settings(const Chain& chain, const GuardedParameters& parameters) {
  require(positive(parameters.steps_per_second), "steps_per_second must be positive");
  const double rate = parameters.steps_per_second;
  const ViteGains gains = gains_of(parameters);
  const auto [alpha, beta] = gains;
  const double reach = std::max(chain.reach(), 1e-6);
  const double gamma = parameters.gamma.value_or(8.5 / (reach * reach));
  require(std::isfinite(gamma) && gamma >= 0 && gamma <= 1e12, "gamma must be in [0, 1e12]");
  require(parameters.path_work >= 0 && parameters.path_work <= 1000000, "path_work must be in [0, 1000000]");
  require(parameters.extrapolation_s > 0, "extrapolation_s must be positive");
  require(std::abs(parameters.tool.axis.norm() - 1) < 1e-9, "the tool's axis must be a unit vector");
  require(positive(parameters.tool.orientation_length_m), "orientation_length_m must be positive");
  const JointVector acceleration =
      parameters.acceleration.size() > 0 ? parameters.acceleration : default_acceleration(chain.velocity());
  require(acceleration.size() == chain.size(), "acceleration needs one value per joint, or none");
  GuardedSettings settings{};
  settings.gains = gains;
  settings.pace = StepPace(rate);
  settings.gamma = gamma;
  const double middle = alpha < 1 ? std::min(0.5, alpha * (1 - beta) / (2 * (1 - alpha))) : 0.5;
  settings.barrier_rate = BarrierRate(std::max(middle, beta / (1 - beta)));
  settings.orientation_length = parameters.tool.orientation_length_m;
  settings.reach = reach;
  const JointVector mobility = joint_mobility(joint_weights_of(chain, parameters.joint_weights));
  for (int i = 0; i < chain.size(); ++i) {
    settings.lower[i] = chain.lower()[i];
    settings.upper[i] = chain.upper()[i];
    settings.speed[i] = chain.velocity()[i] / rate;
    require(acceleration[i] > 0, "an acceleration limit must be positive");
    settings.acceleration[i] = acceleration[i] / (rate * rate);
    settings.mobility[i] = mobility[i];
    if (mobility[i] > 0) continue;
    settings.lower[i] = -std::numeric_limits<double>::infinity();
    settings.upper[i] = std::numeric_limits<double>::infinity();
    settings.speed[i] = 0;
  }
  return settings;
}

}  // namespace multireach::controller
