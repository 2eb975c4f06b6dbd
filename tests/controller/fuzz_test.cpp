#include <gtest/gtest.h>

#include <cstdlib>

#include "controller/law/guarded_law.hpp"
#include "controller/reach_controller.hpp"
#include "kinematics/default_limits.hpp"
#include "tests/test_arms.hpp"

// Makes random calls in random order, with any numbers: the output must be finite and inside the limits.
// MULTIREACH_FUZZ_CALLS sets the number of calls (10^7 in tools/test.sh --full), MULTIREACH_FUZZ_SEED the first seed.

namespace multireach::controller {
namespace {

int64_t from_environment(const char* name, int64_t otherwise) {
  const char* text = std::getenv(name);
  return text ? std::strtoll(text, nullptr, 10) : otherwise;
}

/// Generates random arguments: mostly plausible ones, some at the extremes of a double, infinite or not a number.
class RandomInput {
 public:
  explicit RandomInput(uint64_t seed) : random_(seed, 77) {}

  double uniform(double from, double to) { return random_.uniform(counter_++, from, to); }
  bool chance(double of_one) { return uniform(0, 1) < of_one; }
  int below(int n) { return std::min(n - 1, static_cast<int>(uniform(0, n))); }
  double number(double scale, double extreme_share = 0.02) {
    if (!chance(extreme_share)) return uniform(-scale, scale);
    static constexpr double kExtremes[] = {0.0,  -0.0, NAN,   INFINITY, -INFINITY, 1e9,  -1e9,
                                           1e5,  -1e5, 1e300, -1e300,   5e-324,    1e-9, 1.7976931348623157e308,
                                           1e15, -1e15};
    return kExtremes[below(std::size(kExtremes))];
  }
  Eigen::Vector3d vector(double scale, double extreme_share = 0.02) {
    const double x = number(scale, extreme_share), y = number(scale, extreme_share), z = number(scale, extreme_share);
    return {x, y, z};
  }
  JointVector joints(int n, double scale) {
    JointVector v(chance(0.02) ? below(kMaxJoints + 1) : n);
    for (double& element : v) element = number(scale);
    return v;
  }
  int64_t time(int64_t now) {
    if (!chance(0.03)) return now + static_cast<int64_t>(uniform(-2e4, 5e4));
    static constexpr int64_t kEdges[] = {INT64_MIN, INT64_MAX, 0, -1, INT64_MAX / 2, INT64_MIN / 2, 1'000'000'000'000};
    return kEdges[below(std::size(kEdges))];
  }
  TaskTarget target(double reach) {
    TaskTarget target{.position = vector(1.2 * reach), .task = static_cast<TaskKind>(below(3))};
    if (chance(0.3)) target.velocity = vector(0.01);
    if (chance(0.05)) target.velocity = vector(1e3);
    target.direction = vector(1, 0.005).stableNormalized();
    target.orientation = Eigen::Quaterniond(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1))
                             .normalized()
                             .toRotationMatrix();
    if (chance(0.05)) target.orientation(below(3), below(3)) = number(1, 0.5);
    return target;
  }
  std::vector<Obstacle> obstacles(double reach) {
    std::vector<Obstacle> list(static_cast<size_t>(chance(0.02) ? 100 : below(6)));
    for (Obstacle& obstacle : list) {
      obstacle.shape = static_cast<Obstacle::Shape>(below(3));
      obstacle.X_WO.translation() = vector(reach, 0.01);
      obstacle.X_WO.linear() = target(reach).orientation;
      obstacle.size = (0.2 * reach * Eigen::Vector3d::Ones() + vector(0.2 * reach, 0.01)) * 0.5;
    }
    return list;
  }

 private:
  CounterRandom random_;
  uint64_t counter_ = 0;
};

/// The same arm without speed limits, and with revolute joint limits of +-`range`, rad.
Chain without_limits(const Chain& chain, double range) {
  std::vector<Joint> list = chain.joints();
  std::vector<Eigen::Isometry3d> fixed;
  for (int i = 0; i <= chain.size(); ++i) fixed.push_back(chain.fixed(i));
  for (Joint& joint : list) {
    joint.velocity = INFINITY;
    if (joint.type != Joint::Type::kRevolute) continue;
    joint.lower = -range;
    joint.upper = range;
  }
  return {list, fixed, "base", "hand"};
}

/// The Hoap2, randomly generated arms of 2 to 9 joints, one of 11 joints, and some arms whose joints have a range of
/// zero or almost zero, a speed of zero, or only huge limits.
Chain arm(uint64_t which) {
  if (which % 16 == 4) return without_limits(testing::hoap2(), 1e9);
  if (which % 16 == 6) return without_limits(testing::odd_arm(6, which), 1e5);
  if (which % 4 == 0) return testing::hoap2();
  const int joints = which % 16 == 1 ? 11 : 2 + static_cast<int>(which % 8);
  Chain odd = testing::odd_arm(joints, which);
  if (which % 4 != 1) return odd;
  std::vector<Joint> list = odd.joints();
  std::vector<Eigen::Isometry3d> fixed;
  for (int i = 0; i <= odd.size(); ++i) fixed.push_back(odd.fixed(i));
  for (size_t i = 0; i < list.size(); i += 2) {
    if (!list[i].limited()) continue;
    list[i].upper = list[i].lower + (i % 4 == 0 ? 0 : 1e-12);
    if (i % 3 == 0) list[i].velocity = 0;
  }
  return {list, fixed, "base", "hand"};
}

/// Checks each output against the limits and the output before it.
struct LimitCheck {
  const Chain& chain;
  JointVector theta, velocity;
  bool fresh = true;

  void check(const Eigen::Ref<const Eigen::VectorXd>& now, const Eigen::Ref<const Eigen::VectorXd>& speed, double rate,
             const JointVector& acceleration) {
    ASSERT_TRUE(now.allFinite() && speed.allFinite());
    for (int i = 0; i < chain.size(); ++i) {
      const double excess = std::max(chain.lower()[i] - now[i], now[i] - chain.upper()[i]);
      const double before = fresh ? INFINITY : std::max(chain.lower()[i] - theta[i], theta[i] - chain.upper()[i]);
      ASSERT_LE(excess, std::max(1e-9, before)) << chain.joint(i).name;
      ASSERT_LE(std::abs(speed[i]), chain.velocity()[i] + 1e-9) << chain.joint(i).name;
      if (fresh || acceleration.size() == 0 || before > 0) continue;
      ASSERT_LE(std::abs(speed[i] - velocity[i]) * rate, acceleration[i] * (1 + 1e-9) + 1e-6) << chain.joint(i).name;
    }
    theta = now;
    velocity = speed;
    fresh = false;
  }
};

void fuzz_law(uint64_t seed, int64_t calls) {
  RandomInput input(seed);
  const Chain chain = arm(seed);
  GuardedParameters parameters{.gamma = std::pow(10, input.uniform(-3, 6))};
  if (input.chance(0.2)) parameters.gamma = 0;
  if (input.chance(0.5)) parameters.acceleration = JointVector::Constant(chain.size(), input.uniform(0.1, 50));
  if (input.chance(0.3)) parameters.body.link_radius_m = input.uniform(0.001, 0.1) * chain.reach();
  parameters.ik = {.starts = 3, .most_starts = 6};
  if (input.chance(0.3)) {
    parameters.joint_weights = JointVector::Ones(chain.size());
    for (Eigen::Index i = 1; i < chain.size(); ++i) {
      parameters.joint_weights[i] = input.chance(0.2) ? INFINITY : std::pow(10, input.uniform(-1, 2));
    }
  }
  GuardedLaw law(chain, parameters);
  LimitCheck limits{.chain = chain, .theta = {}, .velocity = {}};
  const double rate = parameters.steps_per_second;
  const JointVector acceleration =
      parameters.acceleration.size() > 0 ? parameters.acceleration : default_acceleration(chain.velocity());
  int until_call = 0;
  for (int64_t k = 0; k < calls; ++k) {
    if (until_call-- > 0) {
      law.step();
    } else {
      until_call = input.below(400);
      switch (input.below(9)) {
        case 0:
          limits.fresh = law.start(input.joints(chain.size(), input.chance(0.1) ? 10 : 2)) || limits.fresh;
          break;
        case 1:
        case 2:
          law.set_target(input.target(chain.reach()));
          break;
        case 3:
          law.update_target(input.target(chain.reach()));
          break;
        case 4: {
          const JointVector posture = input.joints(chain.size(), 3);
          law.set_joint_target(posture.size() == chain.size() && input.chance(0.8) ? chain.clamped(posture) : posture);
          break;
        }
        case 5:
          law.set_target(input.target(chain.reach()), input.joints(chain.size(), 3));
          break;
        case 6:
          law.compensate(input.joints(chain.size(), input.chance(0.5) ? 0 : 0.5));
          break;
        case 7:
          law.set_obstacles(input.obstacles(chain.reach()));
          break;
        case 8: {
          const GuardedLaw copy = law;
          law = copy;
          break;
        }
      }
    }
    ASSERT_NO_FATAL_FAILURE(limits.check(law.theta(), law.velocity() * rate, rate, acceleration))
        << "seed " << seed << ", call " << k;
    ASSERT_TRUE(law.x().allFinite() && law.x_target().allFinite() && std::isfinite(law.gamma()) &&
                std::isfinite(law.residual_m()))
        << "seed " << seed << ", call " << k;
    // A locked joint stays where it is, also outside its limits, and so does its element of theta_T.
    for (int i = 0; i < chain.size(); ++i) {
      const double at = law.theta_target()[i];
      const bool locked = parameters.joint_weights.size() > 0 && std::isinf(parameters.joint_weights[i]);
      if (locked) {
        ASSERT_EQ(at, law.theta()[i]) << "seed " << seed << ", call " << k;
      } else {
        ASSERT_TRUE(at >= chain.lower()[i] && at <= chain.upper()[i]) << "seed " << seed << ", call " << k;
      }
    }
  }
}

void fuzz_controller(uint64_t seed, int64_t calls) {
  RandomInput input(seed);
  const Chain chain = arm(seed);
  GuardedParameters law;
  if (input.chance(0.5)) law.acceleration = JointVector::Constant(chain.size(), input.uniform(0.1, 50));
  ReachOptions options{.law = law,
                       .on_target_lost = static_cast<OnTargetLost>(input.below(3)),
                       .feedback = static_cast<Feedback>(input.below(2)),
                       .task = input.chance(0.7) ? TaskKind::kPosition : static_cast<TaskKind>(input.below(3))};
  options.ik = {.starts = 3, .most_starts = 6};
  ReachController controller(chain, options);
  LimitCheck limits{.chain = chain, .theta = {}, .velocity = {}};
  const double rate = 1e6 / static_cast<double>(options.tick_us);
  int64_t now = 1'000'000'000;
  Eigen::Vector3d position = 0.5 * chain.reach() * Eigen::Vector3d::Ones();
  for (int64_t k = 0; k < calls; ++k) {
    const int call = input.below(100);
    if (call < 45) {
      position += input.vector(0.01, 0);
      if (input.chance(0.02)) position = input.vector(chain.reach());
      TargetObservation seen{.utime = input.time(now), .seen = !input.chance(0.1), .position = position};
      if (input.chance(0.02)) seen.position = input.vector(1e9, 0.3);
      if (input.chance(0.3)) seen.velocity = input.vector(0.3, 0.01);
      if (input.chance(0.3)) seen.covariance = input.vector(1e-4, 0.05).asDiagonal();
      if (input.chance(0.02)) seen.covariance = input.vector(1, 0.3) * input.vector(1, 0.3).transpose();
      controller.observe(seen);
    } else if (call < 55) {
      JointVector measured = input.joints(chain.size(), 2);
      if (limits.theta.size() > 0 && input.chance(0.9)) {
        measured = limits.theta + JointVector::Constant(chain.size(), input.number(0.1));
      }
      controller.observe_robot(measured);
    } else if (call < 56) {
      limits.fresh = controller.start(input.joints(chain.size(), 1)) || limits.fresh;
    } else if (call < 58) {
      controller.restart_grid(input.time(now));
    } else if (call < 59) {
      controller.set_obstacles(input.obstacles(chain.reach()));
    } else if (controller.started() && controller.next_tick()) {
      now = *controller.next_tick();
      const ReachOutput output = controller.tick();
      ASSERT_TRUE(output.x.allFinite() && output.x_T.allFinite() && std::isfinite(output.condition_number))
          << "seed " << seed << ", call " << k;
      ASSERT_NO_FATAL_FAILURE(limits.check(output.theta, output.velocity, rate, {}))
          << "seed " << seed << ", call " << k;
    }
  }
}

constexpr int64_t kCallsEach = 4000;

TEST(Fuzz, NothingMakesTheGuardedLawBreakALimit) {
  const int64_t calls = from_environment("MULTIREACH_FUZZ_CALLS", 40000) / 2;
  const int64_t first = from_environment("MULTIREACH_FUZZ_SEED", 1);
  for (int64_t k = 0; k * kCallsEach < calls && !HasFatalFailure(); ++k) {
    fuzz_law(static_cast<uint64_t>(first + k), kCallsEach);
  }
}

TEST(Fuzz, NothingMakesTheControllerBreakALimit) {
  const int64_t calls = from_environment("MULTIREACH_FUZZ_CALLS", 40000) / 2;
  const int64_t first = from_environment("MULTIREACH_FUZZ_SEED", 1);
  for (int64_t k = 0; k * kCallsEach < calls && !HasFatalFailure(); ++k) {
    fuzz_controller(static_cast<uint64_t>(first + k), kCallsEach);
  }
}

}  // namespace
}  // namespace multireach::controller
