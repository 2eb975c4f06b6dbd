// Compares the law `paper` with an independent implementation of Eqs. (19)-(28): plain arrays, Gauss-Jordan
// elimination, and Orocos KDL for the arm. The two share no code.
#include "controller/law/paper_law.hpp"
#include "controller/law/paper_equations.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <limits>
#include <vector>

#include "tests/kinematics/kdl_chain.hpp"
#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

using Vec = std::vector<double>;
using Mat = std::vector<Vec>;

class KdlArm {
 public:
  explicit KdlArm(const KDL::Chain& chain) : chain_(chain), fk_(chain_), jac_(chain_) {}
  size_t n() const { return chain_.getNrOfJoints(); }
  Vec position(const Vec& q) {
    KDL::Frame frame;
    fk_.JntToCart(array(q), frame);
    return {frame.p(0), frame.p(1), frame.p(2)};
  }
  Mat jacobian(const Vec& q) {
    KDL::Jacobian j(static_cast<unsigned>(n()));
    jac_.JntToJac(array(q), j);
    Mat m(3, Vec(n()));
    for (size_t r = 0; r < 3; ++r) {
      for (size_t c = 0; c < n(); ++c) m[r][c] = j(static_cast<unsigned>(r), static_cast<unsigned>(c));
    }
    return m;
  }

 private:
  static KDL::JntArray array(const Vec& q) {
    KDL::JntArray a(static_cast<unsigned>(q.size()));
    for (size_t i = 0; i < q.size(); ++i) a(static_cast<unsigned>(i)) = q[i];
    return a;
  }
  KDL::Chain chain_;
  KDL::ChainFkSolverPos_recursive fk_;
  KDL::ChainJntToJacSolver jac_;
};

Vec solve3(Mat a, Vec b) {
  for (size_t c = 0; c < 3; ++c) {
    size_t pivot = c;
    for (size_t r = c + 1; r < 3; ++r) {
      if (std::abs(a[r][c]) > std::abs(a[pivot][c])) pivot = r;
    }
    std::swap(a[c], a[pivot]);
    std::swap(b[c], b[pivot]);
    for (size_t r = 0; r < 3; ++r) {
      if (r == c) continue;
      const double f = a[r][c] / a[c][c];
      for (size_t k = 0; k < 3; ++k) a[r][k] -= f * a[c][k];
      b[r] -= f * b[c];
    }
  }
  for (size_t c = 0; c < 3; ++c) b[c] /= a[c][c];
  return b;
}

/// J W J^T + diagonal * I
Mat weighted_square(const Mat& J, const Vec& w, double diagonal) {
  Mat m(3, Vec(3, 0.0));
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c) {
      for (size_t i = 0; i < w.size(); ++i) m[r][c] += J[r][i] * w[i] * J[c][i];
    }
    m[r][r] += diagonal;
  }
  return m;
}

double row_dot(const Mat& J, size_t row, const Vec& v) {
  double sum = 0;
  for (size_t i = 0; i < v.size(); ++i) sum += J[row][i] * v[i];
  return sum;
}

struct Second {
  Vec theta, theta_dot, x, x_dot, theta_T;

  void step(KdlArm& arm, const Chain& limits, double alpha, double beta, double gamma, const Vec& x_T) {
    const size_t n = theta.size();
    Vec joint(n), hand(3), w(n);
    for (size_t i = 0; i < n; ++i) joint[i] = theta_dot[i] + alpha * (-theta_dot[i] + beta * (theta_T[i] - theta[i]));
    for (size_t i = 0; i < 3; ++i) hand[i] = x_dot[i] + alpha * (-x_dot[i] + beta * (x_T[i] - x[i]));
    for (size_t i = 0; i < n; ++i) {
      const Joint& j = limits.joint(static_cast<int>(i));
      if (j.type == Joint::Type::kContinuous) {
        w[i] = gamma;
      } else if (theta[i] < j.lower || theta[i] > j.upper) {
        w[i] = 0;
      } else {
        w[i] = gamma / 2 * (1 - std::cos(2 * M_PI * (theta[i] - j.lower) / (j.upper - j.lower)));
      }
    }
    const Mat J = arm.jacobian(theta);
    Vec gap(3);
    for (size_t r = 0; r < 3; ++r) gap[r] = hand[r] - row_dot(J, r, joint);
    const Vec lambda = solve3(weighted_square(J, w, 1), gap);
    for (size_t i = 0; i < n; ++i)
      theta_dot[i] = joint[i] + w[i] * (J[0][i] * lambda[0] + J[1][i] * lambda[1] + J[2][i] * lambda[2]);
    for (size_t r = 0; r < 3; ++r) x_dot[r] = row_dot(J, r, theta_dot);
    for (size_t i = 0; i < n; ++i) theta[i] += theta_dot[i];
    x = arm.position(theta);
    const Mat J_T = arm.jacobian(theta_T);
    const Vec at = arm.position(theta_T);
    Vec difference(n), push(3);
    for (size_t i = 0; i < n; ++i) difference[i] = theta_T[i] - theta[i];
    for (size_t r = 0; r < 3; ++r) push[r] = row_dot(J_T, r, difference) + x_T[r] - at[r];
    const Vec mu = solve3(weighted_square(J_T, Vec(n, 1.0), 0), push);
    for (size_t i = 0; i < n; ++i)
      theta_T[i] += J_T[0][i] * mu[0] + J_T[1][i] * mu[1] + J_T[2][i] * mu[2] - difference[i];
  }
};

constexpr uint64_t kSeed = 19;

/// Repeated full steps of (27) can be chaotic: errors grow exponentially, and after some steps two correct programs
/// give unrelated results. A perturbed run measures this growth: it starts with the error kSmallError in theta_T, and
/// the comparison ends when its error exceeds kGrownError.
constexpr double kSmallError = 1e-13, kGrownError = 1e-10;

/// The difference that two backward stable programs may have after one update of theta_T: relative rounding errors of a
/// few units in the last place, times the condition number of J_T J_T^T, times the size of the step (Higham, Accuracy
/// and Stability of Numerical Algorithms, 2nd ed., Theorems 9.4 and 10.4, with 3 n + 1 = 10 for n = 3, twice).
double rounding_of_update(const Chain& chain, const PaperState& state) {
  Eigen::Vector3d x;
  PositionJacobian J;
  chain.position_and_jacobian(state.theta_target, x, J);
  const double step = (state.theta_target - state.theta).norm();
  return 20 * std::numeric_limits<double>::epsilon() * condition_number(J * J.transpose()) * std::max(step, 1e-3);
}

TEST(PaperLaw, AgreesWithASecondWritingToRounding) {
  for (const auto& file : testing::all_arm_files()) {
    const Chain chain = testing::load(file);
    KdlArm arm(testing::kdl_chain(testing::file_text(file.path), file.base, file.tip));
    const CounterRandom random(kSeed);
    constexpr int kReaches = 20, kSteps = 300;
    int compared = 0;
    for (uint64_t k = 0; k < kReaches; ++k) {
      const JointVector start = testing::random_posture(chain, random, 2 * k, 0.1);
      const JointVector goal = testing::random_posture(chain, random, 2 * k + 1, 0.2);
      const Eigen::Vector3d x_T = chain.position(goal);
      const double gamma = k % 2 ? 350 : 50;
      PaperState first = paper_state_at_rest(chain, start, goal);
      PaperState beside = paper_state_at_rest(chain, start, goal.array() + kSmallError);
      const Vec theta(start.begin(), start.end());
      Second second{theta, Vec(theta.size(), 0.0), arm.position(theta), Vec(3, 0.0), Vec(goal.begin(), goal.end())};
      double growth = 1, rounding = 0;
      for (int step = 0; step < kSteps; ++step, ++compared) {
        rounding += rounding_of_update(chain, first);
        paper_step(chain, {.gains = {}, .gamma = gamma}, x_T, Eigen::Vector3d::Zero(), first);
        second.step(arm, chain, 0.08, 0.03, gamma, {x_T.x(), x_T.y(), x_T.z()});
        paper_step(chain, {.gains = {}, .gamma = gamma}, x_T, Eigen::Vector3d::Zero(), beside);
        const double apart = (first.theta_target - beside.theta_target).cwiseAbs().maxCoeff();
        if (!(apart < kGrownError)) break;
        growth = std::max(growth, apart / kSmallError);
        double worst = 0;
        for (size_t i = 0; i < theta.size(); ++i) {
          const auto at = static_cast<Eigen::Index>(i);
          worst = std::max({worst, std::abs(first.theta[at] - second.theta[i]),
                            std::abs(first.theta_target[at] - second.theta_T[i])});
        }
        ASSERT_LT(worst, growth * rounding) << file.path << ", seed " << kSeed << ", reach " << k << ", step " << step;
      }
    }
    EXPECT_GT(compared, kReaches * kSteps / 2) << file.path;
  }
}

TEST(PaperLaw, ReachesWithTheHandStraighterForLargerGamma) {
  const Chain chain = testing::hoap2();
  JointVector start(4), goal(4);
  start << 0.6, -0.4, -0.3, -0.6;
  goal << -0.7, -0.6, -0.3, -1.2;
  const auto path_ratio = [&](double gamma) {
    PaperState state = paper_state_at_rest(chain, start, goal);
    const Eigen::Vector3d x_T = chain.position(goal), from = state.x;
    double length = 0;
    for (int k = 0; k < 700; ++k) {
      const Eigen::Vector3d before = state.x;
      paper_step(chain, {.gains = {}, .gamma = gamma}, x_T, Eigen::Vector3d::Zero(), state);
      length += (state.x - before).norm();
    }
    EXPECT_LT((state.x - x_T).norm(), 1e-5) << gamma;
    return length / (x_T - from).norm();
  };
  EXPECT_GT(path_ratio(0), path_ratio(350));
}

TEST(PaperLaw, WithoutLimitAvoidanceEveryWeightIsGamma) {
  const Chain chain = testing::hoap2();
  JointVector near_limits = chain.lower();
  near_limits.array() += 0.01;
  const PaperParameters with, without{.gains = {}, .gamma = 350, .limit_avoidance = false};
  EXPECT_LT(paper_weights(chain, with, near_limits).maxCoeff(), 0.2);
  EXPECT_EQ(paper_weights(chain, without, near_limits), JointVector::Constant(4, 350));
  // The step must use these weights: near the limits, limit avoidance suppresses the hand's attractor.
  JointVector goal(4);
  goal << -0.7, -0.6, -0.3, -1.2;
  PaperState heard = paper_state_at_rest(chain, near_limits, near_limits), unheard = heard;
  paper_step(chain, without, chain.position(goal), Eigen::Vector3d::Zero(), heard);
  paper_step(chain, with, chain.position(goal), Eigen::Vector3d::Zero(), unheard);
  EXPECT_GT(heard.theta_dot.norm(), 100 * unheard.theta_dot.norm());
}

}  // namespace
}  // namespace multireach::controller
