#include "studies/figures/motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace multireach {
namespace {

double mean_tick(const Motion& motion) {
  return (motion.back().time - motion.front().time) / static_cast<double>(motion.size() - 1);
}

/// Sum of the squared third differences of one member of Moment.
template <class Value>
double third_differences(const Motion& motion, Value Moment::*value) {
  double sum = 0;
  for (size_t k = 0; k + 3 < motion.size(); ++k) {
    sum +=
        (motion[k + 3].*value - 3 * motion[k + 2].*value + 3 * motion[k + 1].*value - motion[k].*value).squaredNorm();
  }
  return sum;
}

template <class Value>
double rms_jerk(const Motion& motion, Value Moment::*value) {
  if (motion.size() < 4) return 0;
  const double mean = third_differences(motion, value) / static_cast<double>(motion.size() - 3);
  return std::sqrt(mean) / std::pow(mean_tick(motion), 3);
}

}  // namespace

std::string measures_csv(const std::string& figure, const std::vector<Measure>& measures) {
  std::string text = "figure,law,quantity,value,unit\n";
  for (const Measure& measure : measures) {
    char number[32];
    std::snprintf(number, sizeof number, "%.6g", measure.value);
    text.append(figure).append(",").append(measure.law).append(",").append(measure.quantity);
    text.append(",").append(number).append(",").append(measure.unit).append("\n");
  }
  return text;
}

Moment moment_of(const Chain& chain, double time, const JointVector& theta, const JointVector& velocity) {
  Moment moment{.time = time, .theta = theta, .velocity = velocity, .theta_target = {}, .x = {}, .x_dot = {}};
  PositionJacobian jacobian;
  chain.position_and_jacobian(theta, moment.x, jacobian);
  moment.x_dot = jacobian * velocity;
  return moment;
}

Moment moment_at(const Motion& motion, double time) {
  const auto after = std::ranges::upper_bound(motion, time, {}, [](const Moment& moment) { return moment.time; });
  if (after == motion.begin()) return motion.front();
  if (after == motion.end()) return motion.back();
  const Moment &a = *(after - 1), &b = *after;
  const double share = (time - a.time) / (b.time - a.time);
  Moment between = a;
  between.time = time;
  between.theta += share * (b.theta - a.theta);
  between.velocity += share * (b.velocity - a.velocity);
  if (a.theta_target.size() > 0) between.theta_target += share * (b.theta_target - a.theta_target);
  between.x += share * (b.x - a.x);
  between.x_dot += share * (b.x_dot - a.x_dot);
  return between;
}

void append_setpoint(Motion& motion, double tick_s, const JointVector& theta, const Eigen::Vector3d& x) {
  Moment moment{.theta = theta,
                .velocity = JointVector::Zero(theta.size()),
                .theta_target = {},
                .x = x,
                .x_dot = Eigen::Vector3d::Zero()};
  if (!motion.empty()) {
    moment.time = static_cast<double>(motion.size()) * tick_s;
    moment.velocity = (theta - motion.back().theta) / tick_s;
    moment.x_dot = (x - motion.back().x) / tick_s;
  }
  motion.push_back(moment);
}

Motion part(const Motion& motion, double from, double until) {
  constexpr double kRounding = 1e-9;
  const auto earlier = [](double limit) { return [limit](const Moment& moment) { return moment.time < limit; }; };
  const auto begin = std::ranges::partition_point(motion, earlier(from - kRounding));
  return {begin, std::partition_point(begin, motion.end(), earlier(until + kRounding))};
}

double path_length(const Motion& motion) {
  double length = 0;
  for (size_t k = 1; k < motion.size(); ++k) length += (motion[k].x - motion[k - 1].x).norm();
  return length;
}

double straightness(const Motion& motion) {
  return path_length(motion) / (motion.back().x - motion.front().x).norm();
}

double bulge(const Motion& motion) {
  const Eigen::Vector3d line = motion.back().x - motion.front().x;
  double largest = 0;
  for (const Moment& moment : motion) {
    largest = std::max(largest, line.cross(moment.x - motion.front().x).norm() / line.squaredNorm());
  }
  return largest;
}

SpeedPeak speed_peak(const Motion& motion) {
  SpeedPeak peak;
  for (const Moment& moment : motion) {
    if (moment.x_dot.norm() > peak.speed) peak = {moment.x_dot.norm(), moment.time};
  }
  return peak;
}

int count_peaks(std::span<const double> values, double share) {
  if (values.empty()) return 0;
  const double enough = share * std::ranges::max(values);
  if (!(enough > 0)) return 0;
  int peaks = 0;
  bool rising = false;
  double high = 0, low = 0;  // extremes since the last change of direction
  for (const double value : values) {
    high = std::max(high, value);
    low = std::min(low, value);
    if (!rising && value > low + enough) {
      rising = true;
      high = value;
    } else if (rising && value < high - enough) {
      ++peaks;
      rising = false;
      low = value;
    }
  }
  return peaks + (rising ? 1 : 0);
}

int speed_peaks(const Motion& motion) {
  std::vector<double> speeds;
  speeds.reserve(motion.size());
  for (const Moment& moment : motion) speeds.push_back(moment.x_dot.norm());
  return count_peaks(speeds, 0.02);
}

double hand_jerk(const Motion& motion) {
  return rms_jerk(motion, &Moment::x);
}

double joint_jerk(const Motion& motion) {
  return rms_jerk(motion, &Moment::theta);
}

double normalised_jerk(const Motion& motion) {
  // Prepend the rest before the movement, so that the jerk at its start is included.
  Motion with_rest(2, motion.front());
  with_rest.insert(with_rest.end(), motion.begin(), motion.end());
  const double duration = motion.back().time - motion.front().time, tick = mean_tick(motion);
  const double integral = third_differences(with_rest, &Moment::x) / std::pow(tick, 5);
  return std::sqrt(0.5 * integral * std::pow(duration, 5)) / path_length(motion);
}

double largest_joint_speed(const Motion& motion) {
  double largest = 0;
  for (const Moment& moment : motion) largest = std::max(largest, moment.velocity.cwiseAbs().maxCoeff());
  return largest;
}

double largest_velocity_step(const Motion& motion) {
  double largest = 0;
  for (size_t k = 1; k < motion.size(); ++k) {
    largest = std::max(largest, (motion[k].velocity - motion[k - 1].velocity).cwiseAbs().maxCoeff());
  }
  return largest;
}

double settled_after(const Motion& motion, const Eigen::Vector3d& target, double within) {
  double since = std::numeric_limits<double>::quiet_NaN();
  for (const Moment& moment : motion) {
    if (!((moment.x - target).norm() <= within)) {
      since = std::numeric_limits<double>::quiet_NaN();
    } else if (std::isnan(since)) {
      since = moment.time;
    }
  }
  return since;
}

Motion averaged(const Motion& motion, double window) {
  Motion smooth = motion;
  for (Moment& moment : smooth) {
    moment.x_dot =
        (moment_at(motion, moment.time + window / 2).x - moment_at(motion, moment.time - window / 2).x) / window;
  }
  return smooth;
}

void append(std::vector<double>& row, const Eigen::Ref<const Eigen::VectorXd>& values, double scale) {
  for (const double value : values) row.push_back(scale * value);
}

Difference difference(const Motion& wanted, const Motion& measured) {
  Difference best;
  for (int delay_ms = 0; delay_ms <= 200; ++delay_ms) {
    Difference now{.delay_s = delay_ms * 1e-3};
    double squares = 0, joint_squares = 0;
    size_t count = 0;
    for (const Moment& moment : measured) {
      if (moment.time < now.delay_s || moment.time - now.delay_s > wanted.back().time) continue;
      const Moment want = moment_at(wanted, moment.time - now.delay_s);
      const double distance = (moment.x - want.x).norm();
      squares += distance * distance;
      joint_squares += (moment.theta - want.theta).squaredNorm();
      now.largest_m = std::max(now.largest_m, distance);
      now.largest_rad = std::max(now.largest_rad, (moment.theta - want.theta).cwiseAbs().maxCoeff());
      ++count;
    }
    now.rms_m = std::sqrt(squares / static_cast<double>(count));
    now.rms_rad =
        std::sqrt(joint_squares / static_cast<double>(count * static_cast<size_t>(measured.front().theta.size())));
    if (delay_ms == 0 || now.rms_m < best.rms_m) best = now;
  }
  return best;
}

void add_reach_measures(Figure& figure, const std::string& law, const Motion& motion, const Eigen::Vector3d& target) {
  const SpeedPeak peak = speed_peak(motion);
  figure.add(law, "path / distance", straightness(motion));
  figure.add(law, "maxima of the hand speed", speed_peaks(motion));
  figure.add(law, "largest hand speed", peak.speed, "m/s");
  figure.add(law, "time of the largest hand speed", peak.time, "s");
  figure.add(law, "within 1 mm for good after", settled_after(motion, target), "s");
  figure.add(law, "hand to target at the end", 1e3 * (motion.back().x - target).norm(), "mm");
}

}  // namespace multireach
