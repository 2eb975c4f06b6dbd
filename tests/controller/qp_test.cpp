#include <gtest/gtest.h>

#include <tuple>

#include "controller/qp/box_qp.hpp"
#include "controller/qp/soft_collision_qp.hpp"
#include "numeric/random.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 23;
constexpr int kJoints = 6;

/// The data that both quadratic programs have in common.
struct Program {
  using Joints = std::array<double, kJoints>;
  int n;
  double gamma;
  std::array<Joints, 3> jacobian;
  Joints wanted;
  std::array<double, 3> hand;
  Joints lower, upper;
  std::array<double, kMaxJoints> mobility;
};

template <class Program>
Program random_program(const CounterRandom& random, uint64_t& counter) {
  Program program{};
  const auto number = [&](double from, double to) { return random.uniform(counter++, from, to); };
  program.n = kJoints;
  program.gamma = std::pow(10, number(-1, 5));
  for (size_t i = 0; i < kJoints; ++i) {
    program.wanted[i] = number(-1, 1);
    const double mobility = std::pow(10, number(-3, 0));
    if constexpr (requires { program.mobility; }) program.mobility[i] = mobility;
    if constexpr (requires { program.stiffness; }) program.stiffness[i] = 1 / mobility;
    for (auto& row : program.jacobian) row[i] = number(-0.4, 0.4);
    const double a = number(-0.5, 0.5), b = number(-0.5, 0.5);
    std::tie(program.lower[i], program.upper[i]) = std::minmax({a, b});
    if (number(0, 1) < 0.2) program.lower[i] = program.upper[i] = a;
    if (number(0, 1) < 0.2) std::tie(program.lower[i], program.upper[i]) = std::pair(-1e300, 1e300);
  }
  for (double& element : program.hand) element = number(-0.5, 0.5);
  return program;
}

/// Violation of the optimality conditions in the box: the largest component of the gradient that the bounds do not
/// block, relative to the terms of the gradient. 1e9 outside the box.
template <class Program>
double violation(const Program& program, const std::array<double, kJoints>& v, std::array<double, kJoints> gradient,
                 double stiffness = 0) {
  double worst = 0;
  for (size_t i = 0; i < kJoints; ++i) {
    if (v[i] < program.lower[i] || v[i] > program.upper[i]) return 1e9;
    if (v[i] <= program.lower[i]) gradient[i] = std::min(gradient[i], 0.0);
    if (v[i] >= program.upper[i]) gradient[i] = std::max(gradient[i], 0.0);
    worst = std::max(worst, std::abs(gradient[i]));
  }
  return worst / (1 + program.gamma + stiffness);
}

template <class Program>
std::array<double, kJoints> gradient_of(const Program& program, const std::array<double, kJoints>& v) {
  std::array<double, kJoints> gradient;
  for (size_t i = 0; i < kJoints; ++i) {
    double stiffness = 1;
    if constexpr (requires { program.mobility; }) stiffness = 1 / program.mobility[i];
    if constexpr (requires { program.stiffness; }) stiffness = program.stiffness[i];
    gradient[i] = stiffness * (v[i] - program.wanted[i]);
  }
  for (size_t m = 0; m < program.hand.size(); ++m) {
    double error = -program.hand[m];
    for (size_t i = 0; i < kJoints; ++i) error += program.jacobian[m][i] * v[i];
    for (size_t i = 0; i < kJoints; ++i) gradient[i] += program.gamma * error * program.jacobian[m][i];
  }
  return gradient;
}

TEST(BoxQp, MeetsTheOptimalityConditions) {
  const CounterRandom random(kSeed);
  uint64_t counter = 0;
  for (int k = 0; k < 20000; ++k) {
    const auto program = random_program<Program>(random, counter);
    std::array<double, kJoints> v;
    const BoxQp<3, kJoints, double> solver{program.n,    program.gamma, program.jacobian, program.wanted,
                                           program.hand, program.lower, program.upper,    program.mobility};
    solver.solve({}, true, v);
    ASSERT_LT(violation(program, v, gradient_of(program, v)), 1e-9) << "seed " << kSeed << ", case " << k;
    auto wrong = v;
    wrong[0] += 1e-3;
    if (k == 0) {
      EXPECT_GT(violation(program, wrong, gradient_of(program, wrong)), 1e-9) << "the check can fail";
    }
  }
}

TEST(SoftCollisionQp, MeetsTheOptimalityConditions) {
  const CounterRandom random(kSeed, 1);
  uint64_t counter = 0;
  int touched = 0;
  for (int k = 0; k < 5000; ++k) {
    auto program = random_program<SoftCollisionQp<kJoints>>(random, counter);
    program.rows = static_cast<int>(program.hand.size());
    std::array<ProximityPair, 5> pairs{};
    for (ProximityPair& pair : pairs) {
      for (size_t i = 0; i < kJoints; ++i) pair.gradient[i] = random.uniform(counter++, -0.3, 0.3);
      pair.clearance = random.uniform(counter++, -0.1, 1);
    }
    program.pairs = pairs;
    program.rate = 0.04;
    auto v = program.wanted;
    program.solve(v);
    auto gradient = gradient_of(program, v);
    for (const ProximityPair& pair : pairs) {
      double missing = -program.rate * pair.clearance;
      for (size_t i = 0; i < kJoints; ++i) missing -= pair.gradient[i] * v[i];
      if (missing <= 0) continue;
      ++touched;
      for (size_t i = 0; i < kJoints; ++i) gradient[i] -= 1e6 * missing * pair.gradient[i];
    }
    ASSERT_LT(violation(program, v, gradient, 1e6), 1e-8) << "seed " << kSeed << ", case " << k;
  }
  EXPECT_GT(touched, 1000);
}

}  // namespace
}  // namespace multireach::controller
