// Figs. 13 and 14 and Table 1: reaches near singularities and joint limits.
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "controller/law/paper_equations.hpp"
#include "numeric/random.hpp"
#include "studies/figures/law_run.hpp"
#include "studies/figures/scenes.hpp"
#include "studies/study/reach_sample.hpp"

namespace multireach {
namespace {

using namespace controller;

constexpr double kGamma = 350;
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
const std::array<const char*, 4> kJoints{"SFE", "SAA", "SHR", "EB"};

/// Condition number of the matrix (31) that the law inverts at the arm's current configuration.
double condition_of(const Chain& chain, const LawRun& run) {
  const Moment moment = run.moment(0);
  if (!moment.theta.allFinite()) return kNone;
  Eigen::Vector3d x;
  PositionJacobian jacobian;
  chain.position_and_jacobian(moment.theta, x, jacobian);
  return condition_number(coherence_matrix(jacobian, run.weights()));
}

/// The largest squared singular value of the Jacobian over random configurations inside the limits, for the bound (32).
double largest_gain(const Chain& chain) {
  const CounterRandom random(1);
  double largest = 0;
  for (uint64_t k = 0; k < 4000; ++k) {
    JointVector theta(chain.size());
    for (int i = 0; i < chain.size(); ++i) {
      theta[i] = random.uniform(k * kMaxJoints + static_cast<uint64_t>(i), chain.lower()[i], chain.upper()[i]);
    }
    if (k == 0) theta = chain.clamped(JointVector::Zero(chain.size()));
    Eigen::Vector3d x;
    PositionJacobian jacobian;
    chain.position_and_jacobian(theta, x, jacobian);
    const Eigen::Matrix3d gain = jacobian * jacobian.transpose();
    largest = std::max(largest, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(gain).eigenvalues().maxCoeff());
  }
  return largest;
}

/// Adds how often Eq. (27) as printed leads theta_T and the arm outside the limits, in random reaches of 3 s each.
void add_random_reaches(Figure& figure, const Chain& chain, const PaperParameters& parameters) {
  constexpr int kReaches = 2000, kSteps = 3 * static_cast<int>(kStepsPerSecond);
  const ReachSampler sampler(chain, 1);
  int outside = 0, far_outside = 0, arm_outside = 0;
  for (uint64_t k = 0; k < kReaches; ++k) {
    const ReachSample sample = sampler.sample(k);
    PaperState state = paper_state_at_rest(chain, sample.start, sample.target_posture);
    double excess = 0, arm_excess = 0;
    for (int step = 0; step < kSteps && state.theta_target.allFinite(); ++step) {
      paper_step(chain, parameters, sample.target, Eigen::Vector3d::Zero(), state);
      excess = std::max(excess, chain.limit_excess(state.theta_target));
      arm_excess = std::max(arm_excess, chain.limit_excess(state.theta));
    }
    if (!state.theta_target.allFinite()) excess = arm_excess = std::numeric_limits<double>::infinity();
    outside += excess * kDegrees > 1;
    far_outside += excess * kDegrees > 90;
    arm_outside += arm_excess * kDegrees > 1;
  }
  const char* name = "literal; 2000 random reaches";
  figure.add(name, "θ_T more than 1° outside the limits", 100.0 * outside / kReaches, "%");
  figure.add(name, "θ_T more than 90° outside", 100.0 * far_outside / kReaches, "%");
  figure.add(name, "the arm more than 1° outside", 100.0 * arm_outside / kReaches, "%");
}

}  // namespace

Figure stretched_scene(const SceneArm& arm) {
  const Chain& chain = arm.chain;
  const JointVector start = hoap2_posture(chain, {0, 0, 0, 0});
  const Eigen::Vector3d stretched = chain.position(hoap2_posture(chain, {0, -90, 0, 0}));
  const Eigen::Vector3d to_shoulder = (chain.fixed(0).translation() - stretched).normalized();
  const PaperParameters parameters{.gains = {}, .gamma = kGamma};
  const double never = std::numeric_limits<double>::infinity(), bound = 1 + kGamma * largest_gain(chain);
  struct Way {
    const char* name;
    double short_m;  // m: how far the target is short of the stretched position
    std::unique_ptr<LawRun> run;
    Motion motion{};
    std::vector<double> conditions{};
  };
  std::array<Way, 5> ways{
      {{"paper; literal", 0, std::make_unique<PaperRun>(chain, parameters, start, never)},
       {"literal; 0.01 mm short", 1e-5, std::make_unique<PaperRun>(chain, parameters, start, never)},
       {"literal; 1 mm short", 1e-3, std::make_unique<PaperRun>(chain, parameters, start, never)},
       {"paper; θ_T searched again", 0, supervised_paper_run(chain, parameters, start)},
       {"guarded", 0, guarded_run(chain, kGamma, start)}}};
  constexpr int kSteps = 4 * static_cast<int>(kStepsPerSecond);
  Figure figure{Table({"time", "literal_y", "literal_z", "literal_condition", "short_y", "short_z", "short_condition",
                       "short1_y", "short1_z", "short1_condition", "paper_y", "paper_z", "paper_condition", "guarded_y",
                       "guarded_z", "guarded_condition", "bound"})};
  for (auto& [name, short_m, run, motion, conditions] : ways) {
    const Eigen::Vector3d target = stretched + short_m * to_shoulder;
    run->set_target(target);
    double largest_condition = 0;
    int finite_steps = -1;
    for (int k = 0; k <= kSteps; ++k) {
      motion.push_back(run->moment(k / kStepsPerSecond));
      conditions.push_back(condition_of(chain, *run));
      if (motion.back().theta.allFinite()) {
        ++finite_steps;
        largest_condition = std::max(largest_condition, conditions.back());
      }
      run->step();
    }
    const bool finite = finite_steps == kSteps;
    figure.add(name, "steps with finite joint angles; of 560", finite_steps);
    figure.add(name, "largest condition number", largest_condition);
    figure.add(name, "bound of Eq. (32)", bound);
    figure.add(name, "path / distance", finite ? straightness(motion) : kNone);
    figure.add(name, "largest joint speed", finite ? largest_joint_speed(motion) : kNone, "rad/s");
    figure.add(name, "within 1 mm for good after", finite ? settled_after(motion, target) : kNone, "s");
    figure.add(name, "hand to target at the end", finite ? 1e3 * (motion.back().x - target).norm() : kNone, "mm");
  }
  add_random_reaches(figure, chain, parameters);
  for (size_t k = 0; k <= static_cast<size_t>(kSteps); k += 2) {
    std::vector<double> row{static_cast<double>(k) / kStepsPerSecond};
    for (const Way& way : ways) {
      const Moment& moment = way.motion[k];
      const bool finite = moment.theta.allFinite();
      row.insert(row.end(), {finite ? 100 * moment.x.y() : kNone, finite ? 100 * moment.x.z() : kNone});
      row.push_back(way.conditions[k]);
    }
    row.push_back(bound);
    figure.curves.row(row);
  }
  return figure;
}

namespace {

/// The variants of the reach from behind the neck.
const std::array<const char*, 6> kVariants{"paper; without",        "paper; with",      "paper; with; literal θ_T",
                                           "paper; with; β = 0.02", "guarded; γ = 350", "guarded; default γ"};

std::unique_ptr<LawRun> neck_run(const Chain& chain, size_t way, const JointVector& start) {
  PaperParameters parameters{.gains = {}, .gamma = kGamma};
  switch (way) {
    case 0:
      parameters.limit_avoidance = false;
      return supervised_paper_run(chain, parameters, start);
    case 1:
      return supervised_paper_run(chain, parameters, start);
    case 2:
      return std::make_unique<PaperRun>(chain, parameters, start);
    case 3:
      parameters.gains.beta = 0.02;
      return supervised_paper_run(chain, parameters, start);
    case 4:
      return guarded_run(chain, kGamma, start);
    default:
      return guarded_run(chain, GuardedLaw(chain).largest_gamma(), start);
  }
}

double largest_excess(const Chain& chain, const Motion& motion) {
  double excess = 0;
  for (const Moment& moment : motion) excess = std::max(excess, chain.limit_excess(moment.theta));
  return excess;
}

/// Random configurations inside the limits with the hand behind the neck, between the shoulders and a little above
/// them.
std::vector<JointVector> behind_the_neck(const Chain& chain, size_t count) {
  const CounterRandom random(1);
  std::vector<JointVector> postures;
  JointVector theta(chain.size());
  for (uint64_t k = 0; postures.size() < count; ++k) {
    for (int i = 0; i < chain.size(); ++i) {
      theta[i] = random.uniform(4 * k + static_cast<uint64_t>(i), chain.lower()[i], chain.upper()[i]);
    }
    const Eigen::Vector3d x = chain.position(theta);
    const bool behind = x.x() > -0.14 && x.x() < -0.07 && std::abs(x.y()) < 0.05 && x.z() > 0.10 && x.z() < 0.20;
    if (behind) postures.push_back(theta);
  }
  return postures;
}

}  // namespace

Figure neck_scene(const SceneArm& arm) {
  const Chain& chain = arm.chain;
  const JointVector start = hoap2_posture(chain, {-60, -175, -85, -105});
  const Eigen::Vector3d front(0.12, -0.12, -0.06);
  constexpr int kReaches = 200;
  std::vector<std::string> columns{"time"};
  for (const char* way : {"without", "with", "literal", "critical", "guarded", "default"}) {
    for (const char* what : {"x", "y", "z", "0", "1", "2", "3"})
      columns.push_back(std::string(way).append("_").append(what));
  }
  for (const char* limit : {"lower", "upper"}) {
    for (const char* joint : {"0", "1", "2", "3"}) columns.push_back(std::string(limit).append("_").append(joint));
  }
  Figure figure{Table(columns)};
  // Table 1 of the paper: the joints' lowest angles, to compare with their lower limits.
  const std::array<std::array<double, 4>, 2> reported{{{-90, -180, -90, -115}, {-83.5, -164.1, -89.9, -107.2}}};
  for (size_t i = 0; i < 4; ++i) {
    const std::string quantity = std::string("lowest angle of ").append(kJoints[i]);
    figure.add("lower limit", quantity, chain.lower()[static_cast<int>(i)] * kDegrees, "°");
    figure.add("reported; without", quantity, reported[0][i], "°");
    figure.add("reported; with", quantity, reported[1][i], "°");
  }
  const std::vector<JointVector> starts = behind_the_neck(chain, kReaches);
  std::array<Motion, kVariants.size()> motions;
  for (size_t way = 0; way < kVariants.size(); ++way) {
    const auto run = neck_run(chain, way, start);
    run->set_target(front);
    const Motion& motion = motions[way] = record(*run, 6);
    JointVector low = motion.front().theta;
    for (const Moment& moment : motion) low = low.cwiseMin(moment.theta);
    for (size_t i = 0; i < 4; ++i) {
      const std::string quantity = std::string("lowest angle of ").append(kJoints[i]);
      figure.add(kVariants[way], quantity, low[static_cast<int>(i)] * kDegrees, "°");
    }
    figure.add(kVariants[way], "farthest beyond a limit", largest_excess(chain, motion) * kDegrees, "°");
    figure.add(kVariants[way], "path / distance", straightness(motion));
    figure.add(kVariants[way], "within 1 mm for good after", settled_after(motion, front), "s");
    int passed = 0, arrived = 0;
    double worst = 0;
    for (const JointVector& from : starts) {
      const auto other = neck_run(chain, way, from);
      other->set_target(front);
      const Motion reach = record(*other, 10);
      const double excess = largest_excess(chain, reach);
      passed += excess > 1e-9;
      arrived += (reach.back().x - front).norm() < 1e-3;
      worst = std::max(worst, excess);
    }
    figure.add(kVariants[way], "200 starts: beyond a limit", 100.0 * passed / kReaches, "%");
    figure.add(kVariants[way], "200 starts: farthest beyond", worst * kDegrees, "°");
    figure.add(kVariants[way], "200 starts: arrived within 10 s", 100.0 * arrived / kReaches, "%");
  }
  for (size_t k = 0; k <= 840; k += 6) {
    std::vector<double> row{static_cast<double>(k) / kStepsPerSecond};
    for (const Motion& motion : motions) {
      append(row, motion[k].x, 100);
      append(row, motion[k].theta, kDegrees);
    }
    append(row, chain.lower(), kDegrees);
    append(row, chain.upper(), kDegrees);
    figure.curves.row(row);
  }
  return figure;
}

}  // namespace multireach
