#include "tools/figures/motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace multireach {

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

int speed_peaks(const Motion& motion) {
  const double enough = 0.02 * speed_peak(motion).speed;
  int peaks = 0;
  bool rising = true;
  double turn = 0;  // the largest speed since it began to rise, or the smallest since it began to fall
  for (const Moment& moment : motion) {
    const double speed = moment.x_dot.norm();
    if (rising) {
      turn = std::max(turn, speed);
      if (speed < turn - enough) {
        ++peaks;
        rising = false;
        turn = speed;
      }
    } else {
      turn = std::min(turn, speed);
      if (speed > turn + enough) {
        rising = true;
        turn = speed;
      }
    }
  }
  return peaks;
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
