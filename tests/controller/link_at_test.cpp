#include "controller/collision/link_at.hpp"

#include <gtest/gtest.h>

#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 83;

/// The distance from the nearest of many points on a link's axis, by brute force.
double distance_from(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& p) {
  double least = INFINITY;
  for (int k = 0; k <= 2000; ++k) least = std::min(least, (from + (to - from) * (k / 2000.0) - p).norm());
  return least;
}

TEST(LinkAt, IsTheLinkWhoseAxisIsNearAndNoneAtTheHand) {
  const Chain chain = testing::hoap2();
  const Body body{.link_radius_m = 0.02};
  const CounterRandom random(kSeed);
  int inside = 0;
  for (uint64_t k = 0; k < 500; ++k) {
    const JointVector theta = testing::random_posture(chain, random, k);
    std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> axes;
    Eigen::Isometry3d X = chain.fixed(0);
    for (int i = 0; i < chain.size(); ++i) {
      X.linear() = X.linear() * Eigen::AngleAxisd(theta[i], chain.joint(i).axis).toRotationMatrix();
      axes.emplace_back(X.translation(), X * chain.fixed(i + 1).translation());
      X = X * chain.fixed(i + 1);
    }
    const CounterRandom place(kSeed, k + 1);
    const auto& [from, to] = axes[static_cast<size_t>(place.uniform(0) * chain.size())];
    const Eigen::Vector3d off(place.uniform(1, -1, 1), place.uniform(2, -1, 1), place.uniform(3, -1, 1));
    const Eigen::Vector3d p = from + place.uniform(4) * (to - from) + 0.03 * off;
    std::optional<int> nearest;
    double least = body.link_radius_m;
    for (size_t i = 0; i < axes.size(); ++i) {
      if ((axes[i].second - axes[i].first).norm() < 1e-6) continue;
      const double distance = distance_from(axes[i].first, axes[i].second, p);
      if (distance < least - 1e-6) {
        nearest = static_cast<int>(i);
        least = distance;
      }
    }
    const bool at_hand = (p - X.translation()).norm() <= 3 * body.link_radius_m;
    const std::optional<int> found = link_at(chain, body, theta, p);
    EXPECT_EQ(found.has_value(), nearest.has_value() && !at_hand) << k;
    if (found && nearest) {
      const auto i = static_cast<size_t>(*found);
      EXPECT_NEAR(distance_from(axes[i].first, axes[i].second, p), least, 1e-4) << k;
      ++inside;
    }
    EXPECT_FALSE(link_at(chain, {}, theta, p)) << "an arm without a body";
  }
  EXPECT_GT(inside, 50);
}

}  // namespace
}  // namespace multireach::controller
