#include "controller/collision/proximity.hpp"

#include <gtest/gtest.h>

#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 81;

std::vector<Obstacle> some_obstacles(const Chain& chain, uint64_t seed) {
  const CounterRandom random(seed);
  uint64_t counter = 0;
  const auto number = [&](double from, double to) { return random.uniform(counter++, from, to); };
  std::vector<Obstacle> obstacles;
  for (int k = 0; k < 6; ++k) {
    Obstacle obstacle;
    obstacle.shape = static_cast<Obstacle::Shape>(k % 3);
    const double x = number(-1, 1), y = number(-1, 1), z = number(-1, 1);
    obstacle.X_WO.translation() = chain.fixed(0).translation() + chain.reach() * Eigen::Vector3d(x, y, z);
    obstacle.X_WO.linear() = Eigen::AngleAxisd(number(-3, 3), Eigen::Vector3d(z, x, y).normalized()).toRotationMatrix();
    const double a = number(0.02, 0.1), b = number(0.02, 0.1), c = number(0.02, 0.1);
    obstacle.size = Eigen::Vector3d(a, b, c);
    obstacles.push_back(obstacle);
  }
  return obstacles;
}

/// The clearance by brute force, at many points on the axes of the links.
double sampled_clearance(const Chain& chain, const Body& body, const std::vector<Obstacle>& obstacles,
                         const JointVector& theta) {
  double least = body.query_distance_m;
  Eigen::Isometry3d X = chain.fixed(0);
  for (int i = 0; i < chain.size(); ++i) {
    X.linear() = X.linear() * Eigen::AngleAxisd(theta[i], chain.joint(i).axis).toRotationMatrix();
    for (int k = 0; k <= 400; ++k) {
      if (chain.fixed(i + 1).translation().norm() < 1e-6) break;
      const Eigen::Vector3d p = X * (chain.fixed(i + 1).translation() * (k / 400.0));
      for (const Obstacle& obstacle : obstacles) {
        Eigen::Vector3d away;
        least = std::min(least, signed_distance(obstacle, p, away) - body.link_radius_m - body.margin_m);
      }
    }
    X = X * chain.fixed(i + 1);
  }
  return least;
}

TEST(Proximity, AgreesWithSampledDistances) {
  const Chain chain = testing::hoap2();
  const Body body{.link_radius_m = 0.02, .self_collision = false};
  Proximity proximity(chain, body);
  const CounterRandom random(kSeed);
  for (uint64_t k = 0; k < 300; ++k) {
    const auto obstacles = some_obstacles(chain, kSeed + k);
    ASSERT_EQ(proximity.set_obstacles(obstacles), 0);
    const JointVector theta = testing::random_posture(chain, random, k);
    const double sampled = sampled_clearance(chain, body, obstacles, theta);
    if (sampled < -body.link_radius_m - body.margin_m + 1e-3)
      continue;  // the depth is only approximate when a link axis is inside an obstacle
    EXPECT_NEAR(proximity.clearance(theta), sampled, 3e-4) << "seed " << kSeed << ", case " << k;
  }
}

TEST(Proximity, GradientsAreTheDerivativesOfTheClearances) {
  const Chain chain = testing::odd_arm(6, 2, false);
  const Body body{.link_radius_m = 0.03};
  Proximity proximity(chain, body);
  const CounterRandom random(kSeed, 1);
  int compared = 0;
  for (uint64_t k = 0; k < 60; ++k) {
    proximity.set_obstacles(some_obstacles(chain, kSeed + k));
    const JointVector theta = testing::random_posture(chain, random, k);
    const auto found = proximity.near_pairs(theta);
    const std::vector<ProximityPair> pairs(found.begin(), found.end());
    for (int i = 0; i < chain.size(); ++i) {
      JointVector more = theta, less = theta;
      more[i] += 1e-6;
      less[i] -= 1e-6;
      const auto after = proximity.near_pairs(more);
      const std::vector<ProximityPair> high(after.begin(), after.end());
      const auto low = proximity.near_pairs(less);
      if (high.size() != pairs.size() || low.size() != pairs.size()) continue;
      for (size_t p = 0; p < pairs.size(); ++p) {
        if (pairs[p].clearance < 0) continue;
        const double slope = (high[p].clearance - low[p].clearance) / 2e-6;
        if (std::abs(slope - pairs[p].gradient[static_cast<size_t>(i)]) < 2e-3)
          ++compared;
        else
          ADD_FAILURE_AT(__FILE__, __LINE__)
              << slope << " " << pairs[p].gradient[static_cast<size_t>(i)] << " case " << k;
      }
    }
  }
  EXPECT_GT(compared, 300);
}

TEST(Proximity, RefusesObstaclesThatAreNone) {
  Proximity proximity(testing::hoap2(), {.link_radius_m = 0.02});
  Obstacle good{.size = {0.1, 0, 0}};
  Obstacle far = good, flat{.shape = Obstacle::Shape::kBox, .size = {0.1, 0.1, 0}}, skewed = good;
  far.X_WO.translation().x() = INFINITY;
  skewed.X_WO.linear() *= 2;
  EXPECT_EQ(proximity.set_obstacles(std::vector{good, far, flat, skewed}), 3);
  EXPECT_EQ(proximity.set_obstacles(std::vector(100, good)), 100 - Proximity::kMaxObstacles);
}

TEST(Proximity, SignedDistanceLeadsOut) {
  const CounterRandom random(kSeed, 2);
  uint64_t counter = 0;
  for (const Obstacle& obstacle : some_obstacles(testing::hoap2(), 5)) {
    for (int k = 0; k < 500; ++k) {
      Eigen::Vector3d p = obstacle.X_WO.translation();
      for (int axis = 0; axis < 3; ++axis) p[axis] += random.uniform(counter++, -0.15, 0.15);
      Eigen::Vector3d away, again;
      const double distance = signed_distance(obstacle, p, away);
      EXPECT_NEAR(away.norm(), 1, 1e-12);
      EXPECT_NEAR(signed_distance(obstacle, p - distance * away, again), 0, 1e-9) << "the surface";
      EXPECT_NEAR(signed_distance(obstacle, p + 0.01 * away, again), distance + 0.01, 1e-9) << "further out";
    }
  }
}

}  // namespace
}  // namespace multireach::controller
