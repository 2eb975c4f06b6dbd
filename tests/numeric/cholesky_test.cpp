#include "numeric/cholesky.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "numeric/random.hpp"

namespace multireach {
namespace {

template <int M>
void compare(uint64_t seed) {
  const CounterRandom random(seed, M);
  uint64_t counter = 0;
  for (int k = 0; k < 5000; ++k) {
    Eigen::Matrix<double, M, 7> J;
    Eigen::Matrix<double, M, 1> b;
    for (double& element : J.reshaped()) element = random.uniform(counter++, -1, 1);
    for (double& element : b) element = random.uniform(counter++, -1, 1);
    Eigen::Matrix<double, M, M> A = J * J.transpose();
    A.diagonal().array() += std::pow(10, random.uniform(counter++, -9, 1));
    const Eigen::Matrix<double, M, 1> y = cholesky_solve<M>(A, b);
    ASSERT_EQ(y, A.llt().solve(b)) << "seed " << seed << ", case " << k << ", M " << M;
    A.template triangularView<Eigen::StrictlyUpper>().setConstant(std::nan(""));
    ASSERT_EQ(cholesky_solve<M>(A, b), y) << "reads the lower triangle only";
  }
}

TEST(Cholesky, HasTheBitsOfEigen) {
  constexpr uint64_t kSeed = 31;
  compare<3>(kSeed);
  compare<5>(kSeed);
  compare<6>(kSeed);
}

}  // namespace
}  // namespace multireach
