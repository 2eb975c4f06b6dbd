#include "robot_bridge/drivers/join_blend.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace multireach::drivers {
namespace {

constexpr double kShare = 0.5;
constexpr double kLongest = 60;  // s
constexpr double kShortest = 1e-3;
constexpr int kSamples = 32;

/// What remains of a unit of position and of velocity, and its three derivatives, at s = 0 to 1: the quintics that
/// begin so, without acceleration, and end in zero.
struct Remains {
  std::array<double, 2> position, velocity, acceleration, jerk;
};

Remains remains(double s) {
  const double s2 = s * s, s3 = s2 * s, s4 = s3 * s, s5 = s4 * s;
  return {.position = {1 - 10 * s3 + 15 * s4 - 6 * s5, s - 6 * s3 + 8 * s4 - 3 * s5},
          .velocity = {-30 * s2 + 60 * s3 - 30 * s4, 1 - 18 * s2 + 32 * s3 - 15 * s4},
          .acceleration = {-60 * s + 180 * s2 - 120 * s3, -36 * s + 96 * s2 - 60 * s3},
          .jerk = {-60 + 360 * s - 360 * s2, -36 + 192 * s - 180 * s2}};
}

}  // namespace

JoinBlend::JoinBlend(const robot_bridge::MotionLimits& limits, const robot_bridge::MotionState& difference)
    : difference_(difference), duration_s_(kShortest) {
  const JointVector &position = difference.position, &velocity = difference.velocity;
  for (int i = 0; i < position.size(); ++i) {
    const double d = std::abs(position[i]) / kShare, v = std::abs(velocity[i]) / kShare;
    // Largest velocity, acceleration and jerk of the quintic from 0 to 1 in unit time: 15/8, 10/sqrt(3) and 60; jerk
    // with which a velocity begins to fall: 36. Both together may need more time.
    duration_s_ = std::max({duration_s_, 1.875 * d / limits.velocity[i], std::sqrt(5.7735 * d / limits.acceleration[i]),
                            std::cbrt(60 * d / limits.jerk[i]), std::sqrt(36 * v / limits.jerk[i])});
  }
  for (int i = 0; i < position.size();) {
    if (keeps(limits, i) || duration_s_ > kLongest) {
      ++i;
    } else {
      duration_s_ *= 1.1;
      i = 0;
    }
  }
}

bool JoinBlend::keeps(const robot_bridge::MotionLimits& limits, int joint) const {
  constexpr double kRounding = 1 + 1e-6;
  const double T = duration_s_;
  const double most_v = kRounding * std::max(kShare * limits.velocity[joint], std::abs(difference_.velocity[joint]));
  const double most_a = kRounding * kShare * limits.acceleration[joint];
  const double most_j = kRounding * kShare * limits.jerk[joint];
  for (int k = 0; k <= kSamples; ++k) {
    const Remains at = remains(static_cast<double>(k) / kSamples);
    const auto sum = [&](const std::array<double, 2>& of) {
      return std::abs(difference_.position[joint] * of[0] + difference_.velocity[joint] * T * of[1]);
    };
    if (sum(at.velocity) > most_v * T || sum(at.acceleration) > most_a * T * T || sum(at.jerk) > most_j * T * T * T)
      return false;
  }
  return true;
}

void JoinBlend::apply(double time_s, robot_bridge::MotionState& command) const {
  if (over(time_s)) return;
  const double T = duration_s_;
  const Remains at = remains(std::max(0.0, time_s / T));
  command.position += at.position[0] * difference_.position + at.position[1] * T * difference_.velocity;
  command.velocity += (at.velocity[0] * difference_.position + at.velocity[1] * T * difference_.velocity) / T;
  command.acceleration +=
      (at.acceleration[0] * difference_.position + at.acceleration[1] * T * difference_.velocity) / (T * T);
}

}  // namespace multireach::drivers
