// Compares a batch of arms, bit for bit, with the same arms run one by one, with every instruction set of this
// processor.
#include "controller/batch/closed_form_batch.hpp"
#include "controller/batch/guarded_batch.hpp"
#include "controller/batch/paper_batch.hpp"
#include "controller/law/paper_equations.hpp"
#include "numeric/instruction_set.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 23;

struct Reach {
  JointVector start, target_posture;
  Eigen::Vector3d target;
  double gamma;
};

/// The k-th of a mix of reaches: from starts inside and outside the limits, to stretched, reachable and unreachable
/// targets, with any gamma.
Reach reach_of(const Chain& chain, uint64_t k) {
  const CounterRandom random(kSeed, k);
  Reach reach;
  reach.start = testing::random_posture(chain, random, 0, 0);
  reach.target_posture = testing::random_posture(chain, random, 1, 0);
  if (k % 5 == 1) {
    for (int i = 0; i < chain.size(); ++i) {
      if (chain.joint(i).limited()) reach.start[i] += random.uniform(200 + static_cast<uint64_t>(i), -0.5, 0.5);
    }
  }
  if (k % 7 == 2) reach.target_posture = chain.clamped(JointVector::Zero(chain.size()));
  reach.target = chain.position(reach.target_posture);
  if (k % 11 == 3) reach.target += 0.2 * chain.reach() * Eigen::Vector3d(1, -1, 0.5);
  if (k % 4 == 1) reach.target_posture = testing::random_posture(chain, random, 2, 0);
  reach.gamma = std::pow(10.0, random.uniform(300, 0, 5));
  return reach;
}

/// Runs `arms` reaches in a batch and one by one. Returns the number of steps compared, summed over the arms.
int64_t compare(const Chain& chain, int arms, int steps, const std::string& what, const JointVector& weights = {}) {
  GuardedBatch batch(chain, {.joint_weights = weights}, arms);
  std::vector<GuardedLaw> laws;
  for (int arm = 0; arm < arms; ++arm) {
    const Reach reach = reach_of(chain, static_cast<uint64_t>(arm));
    EXPECT_TRUE(batch.start(arm, reach.start, reach.target, reach.target_posture, reach.gamma));
    GuardedParameters parameters;
    parameters.gamma = reach.gamma;
    parameters.joint_weights = weights;
    laws.emplace_back(chain, parameters);
    laws.back().start(reach.start);
    laws.back().set_target({.position = reach.target}, reach.target_posture);
  }
  for (int step = 0; step < steps; ++step) {
    batch.step();
    for (int arm = 0; arm < arms; ++arm) {
      const ArmBlock& block = batch.block(arm / kRowLanes);
      const int lane = arm % kRowLanes;
      laws[static_cast<size_t>(arm)].step();
      const GuardedLaw& law = laws[static_cast<size_t>(arm)];
      bool same = law.gamma() == block.gamma[lane];
      for (int i = 0; i < chain.size(); ++i) {
        same = same && law.theta()[i] == block.joints[i].theta[lane] &&
               law.velocity()[i] == block.joints[i].velocity[lane] &&
               law.theta_target()[i] == block.joints[i].theta_target[lane];
      }
      for (int k = 0; k < 3; ++k) same = same && law.x()[k] == block.x[k][lane];
      if (!same) {
        ADD_FAILURE() << what << ": arm " << arm << " parts at step " << step << ", seed " << kSeed;
        return 0;
      }
    }
  }
  int64_t choices = 0;
  for (const GuardedLaw& law : laws) choices += law.ik_searches();
  EXPECT_EQ(batch.ik_searches(), choices) << what;
  return int64_t{arms} * steps;
}

class EveryInstructionSet : public ::testing::Test {
 protected:
  ~EveryInstructionSet() override { select_instruction_set(before_); }
  std::string before_ = active_instruction_set();
};

TEST_F(EveryInstructionSet, GivesTheBitsOfOneArmAlone) {
  for (const std::string& name : available_instruction_sets()) {
    ASSERT_TRUE(select_instruction_set(name));
    for (const auto& file : testing::all_arm_files()) {
      compare(testing::load(file), 43, 900, name + ", " + file.path);
    }
  }
  EXPECT_FALSE(select_instruction_set("PDP-11"));
}

TEST_F(EveryInstructionSet, GivesTheBitsOfOneArmAloneWithWeightsToo) {
  for (const std::string& name : available_instruction_sets()) {
    ASSERT_TRUE(select_instruction_set(name));
    for (const Chain& chain : {testing::hoap2(), testing::seven_joint_arm().chain}) {
      JointVector weights = JointVector::Ones(chain.size());
      weights[0] = INFINITY;
      weights[2] = 7;
      compare(chain, 19, 600, name, weights);
    }
  }
}

/// Repeated full steps of (27) can be chaotic, so each step is compared on its own, starting from the batch's state.
TEST_F(EveryInstructionSet, TakesTheStepsOfThePaper) {
  for (const std::string& name : available_instruction_sets()) {
    ASSERT_TRUE(select_instruction_set(name));
    for (const auto& file : testing::all_arm_files()) {
      const Chain chain = testing::load(file);
      const int n = chain.size();
      constexpr int kArms = 16, kSteps = 400;
      PaperBatch batch(chain, {}, std::numeric_limits<double>::infinity(), kArms);
      std::vector<double> gamma;
      for (int arm = 0; arm < kArms; ++arm) {
        const Reach reach = reach_of(chain, static_cast<uint64_t>(arm));
        gamma.push_back(reach.gamma);
        ASSERT_TRUE(batch.start(arm, reach.start, reach.target, reach.target_posture, reach.gamma));
      }
      double worst = 0;
      int64_t compared = 0;
      for (int step = 0; step < kSteps; ++step) {
        std::vector<PaperState> before(kArms);
        std::vector<Eigen::Vector3d> target(kArms);
        for (int arm = 0; arm < kArms; ++arm) {
          const ArmBlock& block = batch.block(arm / kRowLanes);
          PaperState& state = before[static_cast<size_t>(arm)];
          state.theta = state.theta_dot = state.theta_target = JointVector(n);
          for (int i = 0; i < n; ++i) {
            state.theta[i] = block.joints[i].theta[arm % kRowLanes];
            state.theta_dot[i] = block.joints[i].velocity[arm % kRowLanes];
            state.theta_target[i] = block.joints[i].theta_target[arm % kRowLanes];
          }
          for (int k = 0; k < 3; ++k) {
            state.x[k] = block.x[k][arm % kRowLanes];
            state.x_dot[k] = block.hand_velocity[k][arm % kRowLanes];
            target[static_cast<size_t>(arm)][k] = block.target[k][arm % kRowLanes];
          }
        }
        batch.step();
        for (int arm = 0; arm < kArms; ++arm) {
          PaperState& state = before[static_cast<size_t>(arm)];
          const ArmBlock& block = batch.block(arm / kRowLanes);
          // The factor by which the step of theta_T amplifies rounding errors.
          Eigen::Vector3d x;
          PositionJacobian J;
          chain.position_and_jacobian(state.theta_target, x, J);
          const double condition = condition_number(J * J.transpose());
          paper_step(chain, {.gains = {}, .gamma = gamma[static_cast<size_t>(arm)]}, target[static_cast<size_t>(arm)],
                     Eigen::Vector3d::Zero(), state);
          if (!(condition < 1e6 && state.theta_target.cwiseAbs().maxCoeff() < 100)) continue;
          ++compared;
          for (int i = 0; i < n; ++i) {
            worst = std::max({worst, std::abs(state.theta[i] - block.joints[i].theta[arm % kRowLanes]),
                              std::abs(state.theta_target[i] - block.joints[i].theta_target[arm % kRowLanes])});
          }
        }
      }
      EXPECT_LT(worst, 1e-9) << name << ", " << file.path << ", seed " << kSeed;
      EXPECT_GT(compared, kArms * kSteps / 4) << name << ", " << file.path;
    }
  }
}

TEST_F(EveryInstructionSet, FindsThePosturesThatOneSearchFinds) {
  const Chain chain = testing::hoap2();
  const MultiStartIk search(chain);
  for (const std::string& name : available_instruction_sets()) {
    ASSERT_TRUE(select_instruction_set(name));
    int answers = 0;
    for (uint64_t k = 0; k < 40; ++k) {
      IkQueries queries;
      const CounterRandom random(kSeed, k);
      std::array<JointVector, kRowLanes> theta;
      std::array<Eigen::Vector3d, kRowLanes> x_T;
      for (uint64_t a = 0; a < kRowLanes; ++a) {
        theta[a] = testing::random_posture(chain, random, 2 * a, 0);
        x_T[a] = chain.position(testing::random_posture(chain, random, 2 * a + 1, 0));
        if (a == 3) x_T[a] *= 1.3;                                                 // often unreachable
        if (a == 4) x_T[a] = chain.position(chain.clamped(JointVector::Zero(4)));  // stretched
        if (a == 5) x_T[a] = chain.fixed(0).translation();                         // at the centre of the shoulder
        for (int c = 0; c < 3; ++c) queries.x_T[static_cast<size_t>(c)][static_cast<int>(a)] = x_T[a][c];
        for (int i = 0; i < 4; ++i) queries.theta[static_cast<size_t>(i)][static_cast<int>(a)] = theta[a][i];
      }
      const uint32_t found = closed_form_batch(search.closed_form_ik(), queries);
      for (size_t a = 0; a < kRowLanes; ++a) {
        const auto one = search.closed_form_nearest(x_T[a], theta[a]);
        ASSERT_EQ(one.has_value(), (found >> a & 1) != 0) << name << ", " << k << ", " << a;
        for (int i = 0; one && i < 4; ++i) {
          ASSERT_EQ((*one)[i], queries.posture[static_cast<size_t>(i)][static_cast<int>(a)]) << name << ", " << k;
        }
        answers += one ? 1 : 0;
      }
    }
    EXPECT_GT(answers, 150) << name;
  }
}

}  // namespace
}  // namespace multireach::controller
