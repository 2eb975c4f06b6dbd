#include "robot_bridge/robot_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace multireach::robot_bridge {
namespace {

constexpr double kImpossible = 1e6;    // rad or m, rad/s or m/s: no joint measures this
constexpr double kStandsBelow = 0.01;  // of the speed limit
constexpr double kTooFast = 2;         // times the speed limit
constexpr double kJump = 0.05;         // rad or m, beyond what kTooFast allows between two measurements
constexpr double kMinSpeedFactor = 0.1;
constexpr double kReordered = 1e6;  // us: a larger step back is one of the robot's clock

bool is_valid(const JointVector& values, Eigen::Index size) {
  return values.size() == size && values.allFinite() && values.cwiseAbs().maxCoeff() < kImpossible;
}

}  // namespace

RobotMonitor::RobotMonitor(const MotionLimits& limits, const MonitorOptions& options, int64_t period_us)
    : limits_(limits), options_(options), period_us_(period_us) {
  if (!(options.max_tracking_error > 0) || options.state_timeout_us <= 0 || options.robot_lost_us <= 0)
    throw std::invalid_argument("the tolerances of the robot's monitor must be positive");
}

/// One message of another publisher must not take the robot away.
bool RobotMonitor::follows_other(int64_t run, bool commanded) {
  others_ = run == other_run_ ? std::min(others_ + 1, kOthers) : 1;
  other_run_ = run;
  return others_ >= kOthers && !(commanded && !late());
}

/// How much older a measurement is than the newest, microseconds, without overflow.
double RobotMonitor::behind(const Measurement& measurement) const {
  return static_cast<double>(newest_->utime) - static_cast<double>(measurement.utime);
}

MeasurementVerdict RobotMonitor::update(const Measurement& measurement, bool commanded) {
  const auto n = limits_.velocity.size();
  if (!is_valid(measurement.theta, n) || !is_valid(measurement.velocity, n)) return MeasurementVerdict::kInvalid;
  if (newest_ && measurement.run != newest_->run) {
    if (!follows_other(measurement.run, commanded)) return MeasurementVerdict::kOtherRobot;
    if (commanded && !fault_) fault_ = "the robot was restarted";
  } else if (newest_ && measurement.utime < newest_->utime && behind(measurement) < kReordered) {
    return MeasurementVerdict::kOlder;
  } else if (newest_ && commanded && !fault_) {
    const double seconds = std::clamp(-behind(measurement) * 1e-6, 0.0, 1.0);
    const JointVector largest = (kTooFast * seconds * limits_.velocity).array() + kJump;
    if (((measurement.theta - newest_->theta).cwiseAbs() - largest).maxCoeff() > 0) {
      fault_ = "the robot's measured position jumped";
    } else if ((measurement.velocity.cwiseAbs() - kTooFast * limits_.velocity).maxCoeff() > 0) {
      fault_ = "the robot moves at more than twice its speed limit";
    }
  }
  if (commanded && measurement.faulted && !fault_) fault_ = kRobotsOwnFault;
  newest_ = measurement;
  others_ = 0;
  age_us_ = 0;
  error_ = tracking_error();
  if (commanded && !fault_ && error_ > options_.max_tracking_error) fault_ = kDoesNotFollow;
  return MeasurementVerdict::kAccepted;
}

/// The largest distance of a joint from the range of its recent commands.
double RobotMonitor::tracking_error() {
  const size_t known = std::min(num_commands_, kHistory);
  if (known == 0) return 0;
  double error = 0;
  for (int i = 0; i < limits_.velocity.size(); ++i) {
    double low = history_[0][i], high = low;
    for (size_t k = 1; k < known; ++k) {
      low = std::min(low, history_[k][i]);
      high = std::max(high, history_[k][i]);
    }
    const double here = std::max(low - newest_->theta[i], newest_->theta[i] - high);
    if (here > error) furthest_joint_ = i;
    error = std::max(error, here);
  }
  return error;
}

void RobotMonitor::commanded(const JointVector& position) {
  history_[num_commands_++ % kHistory] = position;
  age_us_ += period_us_;
}

void RobotMonitor::rest_at(const JointVector& position) {
  history_[0] = position;
  num_commands_ = 1;
  age_us_ = 0;
  error_ = 0;
}

const char* RobotMonitor::fault() const {
  if (fault_) return fault_;
  return age_us_ > options_.robot_lost_us ? "no ROBOT_STATE: the robot is lost" : nullptr;
}

bool RobotMonitor::stands() const {
  return newest_ && (newest_->velocity.cwiseAbs() - kStandsBelow * limits_.velocity).maxCoeff() <= 0;
}

double RobotMonitor::speed_factor() const {
  return std::clamp(2 - 2 * error_ / options_.max_tracking_error, kMinSpeedFactor, 1.0);
}

}  // namespace multireach::robot_bridge
