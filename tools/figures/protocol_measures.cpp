#include "tools/figures/protocol_measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace multireach {
namespace {

/// Sum of the squares of the third differences, over tick_s^6.
template <class Value>
double jerk_squares(std::span<const Value> values, double tick_s) {
  double sum = 0;
  for (size_t k = 0; k + 3 < values.size(); ++k) {
    sum += (values[k + 3] - 3 * values[k + 2] + 3 * values[k + 1] - values[k]).squaredNorm();
  }
  return sum / std::pow(tick_s, 6);
}

template <class Value>
double rms_jerk_of(std::span<const Value> values, double tick_s) {
  if (values.size() < 4) return 0;
  return std::sqrt(jerk_squares(values, tick_s) / static_cast<double>(values.size() - 3));
}

double length_of(std::span<const Eigen::Vector3d> hand) {
  double length = 0;
  for (size_t k = 1; k < hand.size(); ++k) length += (hand[k] - hand[k - 1]).norm();
  return length;
}

}  // namespace

int count_peaks(std::span<const double> values, double part) {
  if (values.empty()) return 0;
  const double least = part * *std::max_element(values.begin(), values.end());
  if (!(least > 0)) return 0;
  int peaks = 0;
  bool rising = false;
  double high = 0, low = 0;  // since the last turn
  for (const double value : values) {
    high = std::max(high, value);
    low = std::min(low, value);
    if (!rising && value > low + least) {
      rising = true;
      high = value;
    } else if (rising && value < high - least) {
      ++peaks;
      rising = false;
      low = value;
    }
  }
  return peaks + (rising ? 1 : 0);
}

ReachMeasures measure_reach(std::span<const Eigen::Vector3d> hand, const Eigen::Vector3d& target, double tick_s) {
  constexpr double kSettled = 0.01, kStandsOut = 0.05;
  ReachMeasures measures;
  const double distance = (target - hand.front()).norm();
  measures.error_m = (target - hand.back()).norm();
  measures.path_ratio = length_of(hand) / distance;
  size_t settled = hand.size() - 1;
  while (settled > 0 && (hand[settled] - target).norm() <= kSettled * distance) --settled;
  settled = std::min(settled + 1, hand.size() - 1);
  measures.settled_s = static_cast<double>(settled) * tick_s;
  // Before the target changed, the hand rested: the jerk of setting out belongs to the reach.
  std::vector<Eigen::Vector3d> moving(3, hand.front());
  moving.insert(moving.end(), hand.begin() + 1, hand.begin() + static_cast<ptrdiff_t>(settled) + 1);
  const double length = length_of(moving);
  const double integral = jerk_squares(std::span<const Eigen::Vector3d>(moving), tick_s) * tick_s;
  measures.normalised_jerk = std::sqrt(0.5 * integral * std::pow(measures.settled_s, 5)) / length;
  std::vector<double> speed;
  for (size_t k = 1; k < hand.size(); ++k) speed.push_back((hand[k] - hand[k - 1]).norm());
  measures.speed_peaks = count_peaks(speed, kStandsOut);
  return measures;
}

double rms_jerk(std::span<const Eigen::Vector3d> places, double tick_s) {
  return rms_jerk_of(places, tick_s);
}

double rms_jerk(std::span<const JointVector> postures, double tick_s) {
  return rms_jerk_of(postures, tick_s);
}

double quantile_of(std::vector<double> values, double q) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto at = static_cast<ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<size_t>(at)];
}

}  // namespace multireach
