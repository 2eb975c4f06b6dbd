#include "robot_bridge/motion_profiles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

namespace multireach::robot_bridge {
namespace {

/// Tolerance of all comparisons with a limit, relative to it: covers rounding.
constexpr double kRounding = 1e-9;
constexpr int kMaxSamples = 256;

/// The coefficients of a polynomial of s from 0 to 1, given by those of s^0, s^1, ..., in the Bernstein basis.
template <size_t kDegree>
std::array<double, kDegree + 1> bernstein(std::array<double, kDegree + 1> coefficients) {
  double binomial = 1;
  for (size_t k = 0; k <= kDegree; ++k) {
    coefficients[k] /= binomial;
    binomial *= static_cast<double>(kDegree - k) / static_cast<double>(k + 1);
  }
  for (size_t row = 1; row <= kDegree; ++row) {
    for (size_t k = kDegree; k >= row; --k) coefficients[k] += coefficients[k - 1];
  }
  return coefficients;
}

double largest(std::span<const double> values) {
  double most = 0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

/// The time in which a stop keeps the jerk: |jerk| is largest at an end of it, 6 v / T^2 + 4 a / T at most.
double shortest_stop(double speed, double acceleration, double jerk) {
  return (4 * acceleration + std::sqrt(16 * acceleration * acceleration + 24 * jerk * speed)) / (2 * jerk);
}

}  // namespace

void StopProfile::at(double time_s, double& q, double& v, double& a) const {
  const double T = duration_s;
  if (T <= 0) {
    q = position;
    v = a = 0;
    return;
  }
  const double s = std::min(time_s / T, 1.0), rest = 1 - s;
  q = position +
      T * (velocity * s * (1 + s * s * (-1 + s / 2)) + acceleration * T * s * s * (0.5 + s * (-2.0 / 3 + s / 4)));
  v = rest * rest * (velocity * (1 + 2 * s) + acceleration * T * s);
  a = rest * (-6 * velocity * s / T + acceleration * (1 - 3 * s));
}

StopProfile stop_profile(const MotionLimits& limits, int joint, double position, double velocity, double acceleration,
                         bool& feasible) {
  StopProfile stop{0, position, velocity, acceleration};
  feasible = true;
  if (velocity == 0 && acceleration == 0) return stop;
  const double A = limits.acceleration[joint], J = limits.jerk[joint];
  const double speed = std::abs(velocity), change = std::abs(acceleration);
  double T = shortest_stop(speed, change, J);
  // The acceleration is a quadratic of s with one extremum inside.
  const auto peak_acceleration = [&] {
    const double linear = -6 * velocity / T - 4 * acceleration, square = 6 * velocity / T + 3 * acceleration;
    const double s = square == 0 ? 0 : -linear / (2 * square);
    const double inside = s > 0 && s < 1 ? std::abs(acceleration + s * (linear + s * square)) : 0;
    return std::max(change, inside);
  };
  // In general a longer stop needs less acceleration; that of the start itself stays. The acceleration in the middle
  // is cheaper to compute, and rules out most durations that are too short.
  const double most = std::max(A, change) * (1 + kRounding);
  const auto too_short = [&] {
    return std::abs(1.5 * velocity + 0.25 * acceleration * T) > most * T * (1 + kRounding) ||
           peak_acceleration() > most;
  };
  for (int k = 0; k < 64 && too_short(); ++k) T *= 1.1;
  stop.duration_s = T;
  const auto inside = [&](double s) {
    double q = 0, v = 0, a = 0;
    stop.at(s * T, q, v, a);
    const double lower = std::min(limits.lower[joint], position), upper = std::max(limits.upper[joint], position);
    return std::abs(v) <= limits.velocity[joint] * (1 + kRounding) && q >= lower - kRounding && q <= upper + kRounding;
  };
  // The velocity is extreme where the acceleration is zero, the position where the velocity is zero.
  const double denominator = 6 * velocity / T + 3 * acceleration;
  const double fastest = denominator == 0 ? 0 : acceleration / denominator;
  const double turning_denominator = 2 * velocity + acceleration * T;
  const double turning = turning_denominator == 0 ? 0 : -velocity / turning_denominator;
  feasible = inside(1) && (!(fastest > 0 && fastest < 1) || inside(fastest)) &&
             (!(turning > 0 && turning < 1) || inside(turning));
  return stop;
}

QuinticSegment::QuinticSegment(const MotionState& start, const MotionState& end, double duration_s)
    : duration_s_(duration_s) {
  const double T = duration_s;
  const auto n = start.position.size();
  coefficients_.resize(n, 6);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double v0 = start.velocity[i] * T, v1 = end.velocity[i] * T;
    const double a0 = start.acceleration[i] * T * T, a1 = end.acceleration[i] * T * T;
    const double d = end.position[i] - start.position[i];
    coefficients_.row(i) << start.position[i], v0, a0 / 2, 10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1,
        -15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1, 6 * d - 3 * (v0 + v1) - 0.5 * (a0 - a1);
  }
}

void QuinticSegment::joint_at(int joint, double s, double& q, double& v, double& a) const {
  const auto c = coefficients_.row(joint);
  q = c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * (c[4] + s * c[5]))));
  v = (c[1] + s * (2 * c[2] + s * (3 * c[3] + s * (4 * c[4] + s * 5 * c[5])))) / duration_s_;
  a = (2 * c[2] + s * (6 * c[3] + s * (12 * c[4] + s * 20 * c[5]))) / (duration_s_ * duration_s_);
}

void QuinticSegment::at(double time_s, MotionState& state) const {
  const double s = std::clamp(time_s / duration_s_, 0.0, 1.0);
  const auto n = coefficients_.rows();
  state.position.resize(n);
  state.velocity.resize(n);
  state.acceleration.resize(n);
  for (int i = 0; i < n; ++i) joint_at(i, s, state.position[i], state.velocity[i], state.acceleration[i]);
}

bool QuinticSegment::keeps(const MotionLimits& limits, double step_s) const {
  const int samples = std::clamp(static_cast<int>(std::ceil(duration_s_ / step_s)), 1, kMaxSamples);
  // What costs little first: most of the durations that are tried for a distant goal fail there.
  for (int i = 0; i < coefficients_.rows(); ++i) {
    if (!keeps_jerk_and_acceleration(limits, i)) return false;
  }
  const auto keeps_at_every = [&](int stride, int joint) {
    return is_far_from_limits(limits, joint, samples) || keeps_position_and_velocity(limits, joint, samples, stride);
  };
  for (const int stride : {16, 1}) {
    for (int i = 0; i < coefficients_.rows(); ++i) {
      if (!keeps_at_every(stride, i)) return false;
    }
  }
  return true;
}

bool QuinticSegment::keeps_jerk_and_acceleration(const MotionLimits& limits, int joint) const {
  const auto c = coefficients_.row(joint);
  const double T = duration_s_, A = limits.acceleration[joint], J = limits.jerk[joint];
  // Jerk: a quadratic of s, extreme at the ends and at its vertex. Acceleration: extreme at the ends and where the jerk
  // is zero.
  const double j0 = 6 * c[3], j1 = 24 * c[4], j2 = 60 * c[5];
  const auto jerk = [&](double s) { return std::abs(j0 + s * (j1 + s * j2)) / (T * T * T); };
  if (std::max(jerk(0), jerk(1)) > J * (1 + kRounding)) return false;
  if (j2 != 0) {
    const double vertex = -j1 / (2 * j2);
    if (vertex > 0 && vertex < 1 && jerk(vertex) > J * (1 + kRounding)) return false;
  }
  double q = 0, v = 0, a = 0;
  const double root = std::sqrt(std::max(j1 * j1 - 4 * j0 * j2, 0.0));
  const double sum = -0.5 * (j1 + std::copysign(root, j1));  // without cancellation
  for (const double s : {1.0, j2 == 0 ? -1 : sum / j2, sum == 0 ? -1 : j0 / sum}) {
    if (!(s > 0 && s <= 1)) continue;
    joint_at(joint, s, q, v, a);
    if (std::abs(a) > A * (1 + kRounding)) return false;
  }
  return true;
}

/// Whether position and velocity, also of a stop, are so far from their limits that no time must be sampled. The
/// segment lies between the smallest and the largest of its Bernstein coefficients. A stop, see StopProfile::at, takes
/// at most `longest`: where it takes 3 / sqrt(2) v / A its acceleration keeps A, for any at its start. It moves by at
/// most T v / 2 + T^2 a / 12, and its velocity grows by at most 4/27 T a.
bool QuinticSegment::is_far_from_limits(const MotionLimits& limits, int joint, int samples) const {
  const auto c = coefficients_.row(joint);
  const double T = duration_s_, A = limits.acceleration[joint], J = limits.jerk[joint], step = T / samples;
  const std::array position = bernstein<5>({c[0], c[1], c[2], c[3], c[4], c[5]});
  const std::array velocity = bernstein<4>({c[1], 2 * c[2], 3 * c[3], 4 * c[4], 5 * c[5]});
  const std::array acceleration = bernstein<3>({2 * c[2], 6 * c[3], 12 * c[4], 20 * c[5]});
  const double v = largest(velocity) / T, a = largest(acceleration) / (T * T);
  const double longest = 1.000001 * std::max(shortest_stop(v, a, J), 1.1 * 3 / std::numbers::sqrt2 * v / A);
  const double distance = longest * (v / 2 + longest * a / 12);
  return v + 4.0 / 27 * longest * a < limits.velocity[joint] - J * step * step / 8 &&
         *std::ranges::min_element(position) - distance > limits.lower[joint] &&
         *std::ranges::max_element(position) + distance < limits.upper[joint];
}

/// Position and velocity, also of a stop, at every `stride`-th of the sampled times.
bool QuinticSegment::keeps_position_and_velocity(const MotionLimits& limits, int joint, int samples, int stride) const {
  const auto c = coefficients_.row(joint);
  const double T = duration_s_, A = limits.acceleration[joint], J = limits.jerk[joint];
  double q = 0, v = 0, a = 0;
  // Between samples, an extreme velocity exceeds theirs by at most J step^2 / 8, an extreme position by A step^2 / 8.
  const double step = T / samples;
  const double speed = limits.velocity[joint] - J * step * step / 8, slack = A * step * step / 8;
  const double lower = std::min(limits.lower[joint], c[0]), upper = std::max(limits.upper[joint], c[0]);
  double before = c[1] / T;
  for (int k = stride; k <= samples; k += stride) {
    joint_at(joint, static_cast<double>(k) / samples, q, v, a);
    if (std::abs(v) > std::max(speed, 0.0)) return false;
    const double room = stride == 1 && v * before < 0 ? slack : 0;  // it turned between the samples
    before = v;
    if (q < lower + room - kRounding || q > upper - room + kRounding) return false;
    bool feasible = false;
    stop_profile(limits, joint, q, v, a, feasible);
    if (!feasible) return false;
  }
  return true;
}

}  // namespace multireach::robot_bridge
