#include "numeric/trigonometry.hpp"

#include <gtest/gtest.h>

#include "numeric/random.hpp"

namespace multireach {
namespace {

TEST(Trigonometry, AgreesWithTheCLibrary) {
  constexpr uint64_t kSeed = 5;
  const CounterRandom random(kSeed);
  for (uint64_t k = 0; k < 200000; ++k) {
    const double scale = std::pow(10, 20 * random.uniform(3 * k) - 10);
    const double y = scale * (2 * random.uniform(3 * k + 1) - 1), x = 2 * random.uniform(3 * k + 2) - 1;
    ASSERT_NEAR(arc_tangent(y, x), std::atan2(y, x), 1e-15) << "seed " << kSeed << ", case " << k;
    ASSERT_NEAR(arc_cosine(x), std::acos(x), 2e-15);
    const double angle = 1e6 * x;
    double s, c;
    sine_and_cosine_of(angle, s, c);
    ASSERT_NEAR(s, std::sin(angle), 1e-10);
    ASSERT_NEAR(c, std::cos(angle), 1e-10);
  }
}

TEST(Trigonometry, IsRightAtTheCorners) {
  constexpr double kPi = std::numbers::pi;
  EXPECT_EQ(arc_tangent(0, 0), 0);
  EXPECT_EQ(arc_tangent(0, 2), 0);
  EXPECT_EQ(arc_tangent(0, -2), kPi);
  EXPECT_EQ(arc_tangent(3, 0), kPi / 2);
  EXPECT_EQ(arc_tangent(-3, 0), -kPi / 2);
  EXPECT_NEAR(arc_tangent(1, 1), kPi / 4, 1e-15);
  EXPECT_NEAR(arc_tangent(1e-300, 1e-300), kPi / 4, 1e-15);
  EXPECT_NEAR(arc_tangent(1e300, -1e300), 3 * kPi / 4, 1e-15);
  EXPECT_DOUBLE_EQ(arc_tangent(1e-200, 1), 1e-200);
  EXPECT_EQ(arc_cosine(1), 0);
  EXPECT_EQ(arc_cosine(-1), kPi);
  EXPECT_TRUE(std::isnan(arc_tangent(NAN, 1)));
  double s, c;
  sine_and_cosine_of(INFINITY, s, c);
  EXPECT_TRUE(std::isnan(s) && std::isnan(c));
}

TEST(Trigonometry, RotationsAreThoseOfEigen) {
  const CounterRandom random(6);
  for (uint64_t k = 0; k < 1000; ++k) {
    const Eigen::Vector3d rpy =
        3 * Eigen::Vector3d(random.uniform(3 * k), random.uniform(3 * k + 1), random.uniform(3 * k + 2));
    const Eigen::Matrix3d expected =
        (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    EXPECT_LT((rotation_from_rpy(rpy) - expected).cwiseAbs().maxCoeff(), 1e-15);
    const Eigen::Vector3d axis = rpy.normalized();
    EXPECT_LT((rotation_about(axis, 7 * k) - Eigen::AngleAxisd(7 * k, axis).toRotationMatrix()).cwiseAbs().maxCoeff(),
              1e-12);
  }
}

TEST(Trigonometry, RotatesFromZAsEigenDoes) {
  constexpr uint64_t kSeed = 6;
  const CounterRandom random(kSeed);
  const auto expected = [](const Eigen::Vector3d& direction) {
    return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), direction).toRotationMatrix();
  };
  for (uint64_t k = 0; k < 10000; ++k) {
    const auto number = [&](uint64_t n) { return 2 * random.uniform(3 * k + n) - 1; };
    const Eigen::Vector3d direction(number(0), number(1), number(2));
    ASSERT_EQ(rotation_from_z(direction), expected(direction)) << "seed " << kSeed << ", case " << k;
  }
  for (int k = 0; k < 3; ++k) {
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Vector3d direction = sign * Eigen::Vector3d::Unit(k);
      EXPECT_EQ(rotation_from_z(direction), expected(direction)) << direction.transpose();
    }
  }
  const Eigen::Vector3d almost_opposite(3e-8, -2e-8, -1);
  EXPECT_LT((rotation_from_z(almost_opposite).col(2) - almost_opposite.normalized()).norm(), 2e-8) << "sqrt(2^-52)";
}

}  // namespace
}  // namespace multireach
