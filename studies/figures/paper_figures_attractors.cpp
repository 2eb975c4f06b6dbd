// Figs. 1, 4 and 9: one attractor, the weight near a joint limit, and where two coupled attractors come to rest.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "controller/law/paper_equations.hpp"
#include "controller/law/supervised_paper_law.hpp"
#include "studies/figures/law_run.hpp"
#include "studies/figures/scenes.hpp"
#include "studies/study/reach_sample.hpp"

namespace multireach {
namespace {

using namespace controller;

/// The overshoot beyond 1 of the recurrence r' = r + v', v' = (1 - alpha) v + alpha beta (1 - r) from r = v = 0. Its
/// error is a damped oscillation with radius sqrt(1 - alpha) and angle phi per step; its velocity first changes sign at
/// step floor(pi / phi). Zero when the roots are real.
double overshoot_in_closed_form(const ViteGains& gains) {
  const double radius = std::sqrt(1 - gains.alpha), cosine = (2 - gains.alpha * (1 + gains.beta)) / (2 * radius);
  if (cosine >= 1) return 0;
  const double phi = std::acos(cosine), k = std::floor(std::numbers::pi / phi);
  return std::pow(radius, k) * (-std::cos(k * phi) + (radius - cosine) / std::sin(phi) * std::sin(k * phi));
}

/// The overshoot of the differential equation (3), whose damping ratio is sqrt(alpha / beta) / 2.
double overshoot_of_equation(const ViteGains& gains) {
  const double ratio = 0.5 * std::sqrt(gains.alpha / gains.beta);
  return ratio < 1 ? std::exp(-std::numbers::pi * ratio / std::sqrt(1 - ratio * ratio)) : 0;
}

struct ViteRun {
  std::vector<double> position{0};
  double overshoot = 0, largest_velocity = 0;
  int settled = 0;  // first step from which on the position stays within 1 % of the target

  explicit ViteRun(const ViteGains& gains) {
    double velocity = 0;
    for (int k = 1; k <= 2000; ++k) {
      velocity = vite_velocity(gains, position.back(), velocity, 1.0);
      position.push_back(position.back() + velocity);
      largest_velocity = std::max(largest_velocity, velocity);
      overshoot = std::max(overshoot, position.back() - 1);
      if (std::abs(position.back() - 1) > 0.01) settled = k + 1;
    }
  }
};

/// Integrates until the arm has rested for three seconds, at most 20 s.
template <class Law>
void run_until_rest(Law& law) {
  int still = 0;
  for (int k = 0; k < 20 * kStepsPerSecond && still < 3 * kStepsPerSecond; ++k) {
    law.step();
    still = law.velocity().cwiseAbs().maxCoeff() < 1e-6 ? still + 1 : 0;
  }
}

}  // namespace

Figure vite_scene(const SceneArm&) {
  const std::array<ViteGains, 6> all{
      {{0.08, 0.03}, {0.08, 0.02}, {0.08, 0.01}, {0.08, 0.08}, {0.04, 0.03}, {0.16, 0.03}}};
  std::vector<std::string> columns{"step"};
  for (const ViteGains& gains : all) {
    char name[64];
    std::snprintf(name, sizeof name, "α = %.2f; β = %.2f", gains.alpha, gains.beta);
    columns.emplace_back(name);
  }
  Figure figure{Table(columns)};
  std::vector<ViteRun> runs;
  for (size_t i = 0; i < all.size(); ++i) {
    const ViteRun& run = runs.emplace_back(all[i]);
    const std::string& law = columns[i + 1];
    figure.add(law, "damping ratio √(α/β)/2", 0.5 * std::sqrt(all[i].alpha / all[i].beta));
    figure.add(law, "overshoot of Eq. (3); closed form", 100 * overshoot_of_equation(all[i]), "%");
    figure.add(law, "overshoot of its Euler steps; closed form", 100 * overshoot_in_closed_form(all[i]), "%");
    figure.add(law, "overshoot of its Euler steps; measured", 100 * run.overshoot, "%");
    figure.add(law, "within 1 % for good after", run.settled, "steps");
    figure.add(law, "largest velocity per distance", run.largest_velocity * kStepsPerSecond, "1/s");
  }
  for (size_t k = 0; k <= 300; k += 2) {
    std::vector<double> row{static_cast<double>(k)};
    for (const ViteRun& run : runs) row.push_back(run.position[k]);
    figure.curves.row(row);
  }
  return figure;
}

Figure weight_scene(const SceneArm& arm) {
  const Chain& chain = arm.chain;
  hoap2_posture(chain, {0, 0, 0, 0});
  const int joint = chain.size() - 1;
  const double lower = chain.lower()[joint], upper = chain.upper()[joint], range = upper - lower;
  JointVector theta = chain.clamped(JointVector::Zero(chain.size()));
  GuardedLaw law(chain, guarded_parameters(chain, 1));
  const auto literal = [&](double angle) {
    return 0.5 * (1 - std::cos(2 * std::numbers::pi * (angle - lower) / range));
  };
  const auto here = [&](double angle) {
    theta[joint] = angle;
    return limit_weights(chain, theta, 1)[joint];
  };
  const auto guarded = [&](double angle) {
    theta[joint] = angle;
    law.start(theta);
    return law.weights()[joint];
  };
  Figure figure{Table({"angle", "literal", "here", "guarded", "lower", "upper"})};
  const double degrees = 180 / std::numbers::pi;
  for (int k = -50; k <= 250; ++k) {
    const double angle = lower + range * k / 200.0;
    figure.curves.row({angle * degrees, literal(angle), here(angle), guarded(angle), lower * degrees, upper * degrees});
  }
  const std::array<std::pair<const char*, double>, 6> angles{{{"at a limit", 0},
                                                              {"5 % of the range inside", 0.05},
                                                              {"a quarter of the range inside", 0.25},
                                                              {"in the middle", 0.5},
                                                              {"5 % of the range outside", -0.05},
                                                              {"half the range outside", -0.5}}};
  for (const auto& [name, share] : angles) {
    const double angle = lower + share * range;
    figure.add("Eq. (28) literally", std::string("w / γ ") + name, literal(angle));
    figure.add("paper", std::string("w / γ ") + name, here(angle));
    figure.add("guarded", std::string("w / γ ") + name, guarded(angle));
  }
  return figure;
}

Figure attractors_scene(const SceneArm& arm) {
  constexpr int kReaches = 2000;
  constexpr double kGamma = 500, kOnDiagonal = std::numbers::pi / 180;
  const Chain& chain = arm.chain;
  hoap2_posture(chain, {0, 0, 0, 0});
  const ReachSampler sampler(chain, 1);
  SupervisedPaperLaw paper(chain, {.gains = {}, .gamma = kGamma}, 0.01, {});
  GuardedLaw guarded(chain, guarded_parameters(chain, kGamma));
  Figure figure{Table(
      {"law", "on_diagonal", "target_0", "rest_0", "target_1", "rest_1", "target_2", "rest_2", "target_3", "rest_3"})};
  const double degrees = 180 / std::numbers::pi;
  int which = 0;
  for (ReachingLaw* law : {static_cast<ReachingLaw*>(&paper), static_cast<ReachingLaw*>(&guarded)}) {
    int on_diagonal = 0, farther = 0;
    double largest = 0, farthest_hand = 0;
    for (uint64_t k = 0; k < kReaches; ++k) {
      const ReachSample sample = sampler.sample(k);
      law->start(sample.start);
      law->set_target({.position = sample.target});
      run_until_rest(*law);
      const JointVector rest = law->theta(), target = law->theta_target();
      const double distance = (rest - target).cwiseAbs().maxCoeff();
      const bool there = distance < kOnDiagonal;
      on_diagonal += there;
      farther += distance > 10 * kOnDiagonal;
      largest = std::max(largest, distance);
      farthest_hand = std::max(farthest_hand, (law->x() - sample.target).norm());
      if (there && k >= 150) continue;  // 150 points show the diagonal; more would only enlarge the figure
      std::vector<double> row{static_cast<double>(which), there ? 1.0 : 0.0};
      for (int i = 0; i < chain.size(); ++i) row.insert(row.end(), {target[i] * degrees, rest[i] * degrees});
      figure.curves.row(row);
    }
    const std::string name = which++ == 0 ? "paper" : "guarded";
    figure.add(name, "reaches", kReaches);
    figure.add(name, "on the diagonal: every joint within 1° of θ_T", 100.0 * on_diagonal / kReaches, "%");
    figure.add(name, "a joint farther than 10° from θ_T", 100.0 * farther / kReaches, "%");
    figure.add(name, "largest distance of a joint from the diagonal", largest * degrees, "°");
    figure.add(name, "largest distance of the hand from its target", 1e3 * farthest_hand, "mm");
  }
  return figure;
}

}  // namespace multireach
