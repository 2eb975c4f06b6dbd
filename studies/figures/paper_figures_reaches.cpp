// Figs. 10, 11 and 12: point-to-point reaches, computed and executed by the simulated robot.
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <tuple>

#include "controller/ik/multi_start.hpp"
#include "studies/figures/executed_reach.hpp"
#include "studies/figures/law_run.hpp"
#include "studies/figures/scenes.hpp"

namespace multireach {
namespace {

using namespace controller;

constexpr double kGamma = 350;
constexpr double kDegrees = 180 / std::numbers::pi;

/// A reach under one law, computed step by step and executed by the simulated robot.
struct ComputedAndExecuted {
  Motion computed;
  ExecutedReach executed;
};

ComputedAndExecuted compute_and_execute(const SceneArm& arm, bool paper, double gamma, const JointVector& start,
                                        const Eigen::Vector3d& target, double seconds) {
  ReachOptions options;
  if (paper) {
    options.law = PaperParameters{.gains = {}, .gamma = gamma};
  } else {
    options.law = guarded_parameters(arm.chain, gamma);
  }
  ComputedAndExecuted reach{.computed = {}, .executed = execute(arm, options, start, target, seconds)};
  const auto law = law_run(arm.chain, paper, gamma, start);
  law->set_target(target);
  reach.computed = record(*law, seconds);
  for (size_t tick = 0; tick < reach.executed.setpoints.size(); ++tick) {
    const JointVector difference = reach.executed.setpoints[tick].theta - reach.computed[7 * tick].theta;
    if (!(difference.norm() < 1e-9)) throw std::logic_error("the controller's set-points are not the law's postures");
  }
  return reach;
}

Eigen::Vector3d reach_target() {
  return {0.10, -0.12, 0.10};
}

/// The reach of Figs. 10 and 11: from the rest configuration of robots/hoap2/robot.yaml up and forward.
ComputedAndExecuted point_to_point(const SceneArm& arm, bool paper) {
  return compute_and_execute(arm, paper, kGamma, hoap2_posture(arm.chain, {12, -17, -12, -52}), reach_target(), 2.5);
}

std::vector<std::string> columns_of(std::initializer_list<const char*> laws, std::initializer_list<const char*> names) {
  std::vector<std::string> columns{"time"};
  for (const char* law : laws) {
    for (const char* name : names) columns.push_back(std::string(law).append("_").append(name));
  }
  return columns;
}

/// Least-squares fit of y = slope x: the slope and the largest relative deviation.
std::pair<double, double> proportion(const std::vector<std::pair<double, double>>& points) {
  double xy = 0, xx = 0, worst = 0;
  for (const auto& [x, y] : points) {
    xy += x * y;
    xx += x * x;
  }
  const double slope = xy / xx;
  for (const auto& [x, y] : points) worst = std::max(worst, std::abs(y / (slope * x) - 1));
  return {slope, worst};
}

constexpr std::array<double, 5> kGammas{0, 100, 350, 2000, 1e6};
constexpr int kDirections = 8;
constexpr double kDistance = 0.1;  // m

Eigen::Vector3d centre() {
  return {0.08, -0.14, -0.02};
}
/// Direction 0 is to the robot's right.
Eigen::Vector3d direction(int k) {
  const double angle = 2 * std::numbers::pi * k / kDirections;
  return {std::sin(angle), -std::cos(angle), 0};
}
Eigen::Vector3d start_of(int k) {
  return centre() - 0.5 * kDistance * direction(k);
}
JointVector start_posture(const Chain& chain, int k) {
  const auto found = MultiStartIk(chain).nearest(start_of(k), hoap2_posture(chain, {12, -17, -12, -52}));
  if (!found) throw std::invalid_argument("no posture of this arm reaches a start of the scene");
  return *found;
}

std::string gamma_name(bool paper, double gamma) {
  char name[64];
  std::snprintf(name, sizeof name, "%s; γ = %.0f", paper ? "paper" : "guarded", gamma);
  return name;
}

}  // namespace

Figure executed_scene(const SceneArm& arm) {
  Figure figure{Table(columns_of({"paper", "guarded"}, {"x", "y", "z", "arm_x", "arm_y", "arm_z", "0", "1", "2", "3",
                                                        "arm_0", "arm_1", "arm_2", "arm_3"}))};
  std::array<ComputedAndExecuted, 2> reaches;
  std::array<Difference, 2> differences;
  for (size_t i = 0; i < 2; ++i) {
    const bool paper = i == 0;
    const std::string law = paper ? "paper" : "guarded";
    reaches[i] = point_to_point(arm, paper);
    const Motion& measured = reaches[i].executed.arm;
    const Difference apart = differences[i] = difference(reaches[i].computed, measured);
    figure.add(law, "delay of the arm (removed)", 1e3 * apart.delay_s, "ms");
    figure.add(law, "RMS distance between computed and executed hand", 1e3 * apart.rms_m, "mm");
    figure.add(law, "largest distance between computed and executed hand", 1e3 * apart.largest_m, "mm");
    figure.add(law, "RMS difference of a joint", apart.rms_rad * kDegrees, "°");
    figure.add(law, "largest difference of a joint", apart.largest_rad * kDegrees, "°");
    figure.add(law, "distance of the reach", 1e3 * (measured.back().x - measured.front().x).norm(), "mm");
  }
  for (int k = 0; k <= 105; ++k) {
    const double time = 0.02 * k;
    std::vector<double> row{time};
    for (size_t i = 0; i < 2; ++i) {
      const Moment computed = moment_at(reaches[i].computed, time);
      const Moment measured = moment_at(reaches[i].executed.arm, time + differences[i].delay_s);
      append(row, computed.x, 100);
      append(row, measured.x, 100);
      append(row, computed.theta, kDegrees);
      append(row, measured.theta, kDegrees);
    }
    figure.curves.row(row);
  }
  return figure;
}

Figure profile_scene(const SceneArm& arm) {
  Figure figure{
      Table(columns_of({"paper", "guarded"}, {"0", "1", "2", "3", "target_0", "target_1", "target_2", "target_3",
                                              "speed", "arm_speed", "rate_0", "rate_1", "rate_2", "rate_3"}))};
  std::array<ComputedAndExecuted, 2> reaches;
  for (size_t i = 0; i < 2; ++i) {
    const bool paper = i == 0;
    const std::string law = paper ? "paper" : "guarded";
    reaches[i] = point_to_point(arm, paper);
    const Motion& motion = reaches[i].computed;
    add_reach_measures(figure, law, motion, reach_target());
    figure.add(law, "largest joint speed", largest_joint_speed(motion), "rad/s");
    const JointVector chosen = motion.front().theta_target, last = motion.back().theta_target;
    figure.add(law, "drift of θ_T; all joints together", (last - chosen).norm() * kDegrees, "°");
    figure.add(law, "way of the joints from start to end",
               (motion.back().theta - motion.front().theta).norm() * kDegrees, "°");
    const Motion smooth = averaged(reaches[i].executed.arm, 0.05);
    const SpeedPeak executed = speed_peak(smooth);
    figure.add(law, "executed: maxima of the hand speed", speed_peaks(reaches[i].executed.arm));
    figure.add(law, "executed: the same; averaged over 50 ms", speed_peaks(smooth));
    figure.add(law, "executed: largest hand speed; averaged over 50 ms", executed.speed, "m/s");
    figure.add(law, "executed: time of the largest hand speed", executed.time, "s");
    figure.add(law, "executed: path / distance", straightness(reaches[i].executed.arm));
  }
  // A reach across the body, which is harder.
  const Eigen::Vector3d across(0.12, -0.04, 0.14);
  const double default_gamma = GuardedLaw(arm.chain).largest_gamma();
  for (const auto& [name, paper, gamma] :
       {std::tuple{"paper; across the body", true, kGamma}, std::tuple{"guarded; across the body", false, kGamma},
        std::tuple{"guarded; across; default γ", false, default_gamma}}) {
    const auto law = law_run(arm.chain, paper, gamma, hoap2_posture(arm.chain, {12, -17, -12, -52}));
    law->set_target(across);
    const Motion motion = record(*law, 6);
    add_reach_measures(figure, name, motion, across);
    figure.add(name, "largest joint speed", largest_joint_speed(motion), "rad/s");
    double excess = 0;
    for (const Moment& moment : motion) excess = std::max(excess, arm.chain.limit_excess(moment.theta));
    figure.add(name, "way of the joints from start to end",
               (motion.back().theta - motion.front().theta).norm() * kDegrees, "°");
    figure.add(name, "farthest beyond a limit", excess * kDegrees, "°");
  }
  for (int k = 0; k <= 160; ++k) {
    const double time = 0.01 * k;
    std::vector<double> row{time};
    for (const ComputedAndExecuted& reach : reaches) {
      const Moment moment = moment_at(reach.computed, time);
      append(row, moment.theta, kDegrees);
      append(row, moment.theta_target, kDegrees);
      row.push_back(moment.x_dot.norm());
      row.push_back(moment_at(reach.executed.arm, time).x_dot.norm());
      append(row, moment.velocity);
    }
    figure.curves.row(row);
  }
  return figure;
}

Figure straight_scene(const SceneArm& arm) {
  std::vector<JointVector> starts;
  starts.reserve(kDirections);
  for (int k = 0; k < kDirections; ++k) starts.push_back(start_posture(arm.chain, k));
  std::vector<std::string> columns{"time"};
  std::vector<Motion> motions;
  std::vector<std::vector<std::pair<double, double>>> speeds;
  const std::vector<double> distances{0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1};
  Figure figure{Table({})};
  for (const bool paper : {true, false}) {
    for (const double gamma : kGammas) {
      const std::string name = gamma_name(paper, gamma);
      double sum = 0, worst = 0, bulges = 0, worst_settled = 0;
      int peaks = 0;
      for (int k = 0; k < kDirections; ++k) {
        const Eigen::Vector3d target = start_of(k) + kDistance * direction(k);
        const auto law = law_run(arm.chain, paper, gamma, starts[static_cast<size_t>(k)]);
        law->set_target(target);
        Motion motion = record(*law, 4);
        sum += straightness(motion) / kDirections;
        worst = std::max(worst, straightness(motion));
        bulges = std::max(bulges, bulge(motion));
        peaks = std::max(peaks, speed_peaks(motion));
        worst_settled = std::max(worst_settled, settled_after(motion, target));
        motions.push_back(std::move(motion));
      }
      auto& pairs = speeds.emplace_back();
      for (const double distance : distances) {
        const auto law = law_run(arm.chain, paper, gamma, starts[0]);
        law->set_target(start_of(0) + distance * direction(0));
        pairs.emplace_back(distance, speed_peak(record(*law, 3)).speed);
      }
      const auto [slope, deviation] = proportion(pairs);
      figure.add(name, "path / distance; mean of 8 directions", sum);
      figure.add(name, "path / distance; worst", worst);
      figure.add(name, "largest distance from the straight line / distance", bulges);
      figure.add(name, "most maxima of the hand speed", peaks);
      figure.add(name, "within 1 mm for good after; worst", worst_settled, "s");
      figure.add(name, "largest speed / distance; reaches of 10 to 100 mm", slope, "1/s");
      figure.add(name, "deviation from proportionality; worst", 100 * deviation, "%");
    }
  }
  // For each law and gamma: x and y of 8 paths, and the speed of the one to the right; then peak speeds by distance.
  for (const char* law : {"paper", "guarded"}) {
    for (size_t g = 0; g < kGammas.size(); ++g) {
      for (const char* what : {"x", "y"}) {
        for (int k = 0; k < kDirections; ++k) {
          columns.push_back(std::string(law).append(1, '_').append(what) + char('0' + g) + char('0' + k));
        }
      }
      columns.push_back(std::string(law).append("_speed") + char('0' + g));
      columns.push_back(std::string(law).append("_peak") + char('0' + g));
    }
  }
  columns.emplace_back("distance");
  figure.curves = Table(columns);
  for (size_t row_index = 0; row_index <= 70; ++row_index) {
    const size_t step = 4 * row_index;
    std::vector<double> row{static_cast<double>(step) / kStepsPerSecond};
    for (size_t law_gamma = 0; law_gamma < speeds.size(); ++law_gamma) {
      const Motion* eight = &motions[law_gamma * kDirections];
      for (const int axis : {0, 1}) {
        for (int k = 0; k < kDirections; ++k) row.push_back(100 * eight[k][step].x[axis]);
      }
      row.push_back(eight[0][step].x_dot.norm());
      row.push_back(row_index < distances.size() ? speeds[law_gamma][row_index].second
                                                 : std::numeric_limits<double>::quiet_NaN());
    }
    row.push_back(row_index < distances.size() ? 100 * distances[row_index] : std::numeric_limits<double>::quiet_NaN());
    figure.curves.row(row);
  }
  return figure;
}

}  // namespace multireach
