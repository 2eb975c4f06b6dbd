// multireach-study straightness: the shortest path against closed forms and bounds; the same numbers with any threads.
#include "studies/straightness/straightness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "studies/straightness/shortest_path.hpp"
#include "tests/test_arms.hpp"

namespace multireach {
namespace {

constexpr uint64_t kSeed = 12;

/// Two revolute joints about z, links of 0.3 and 0.2 m. Every position is reached by at most two configurations.
Chain planar_arm(double elbow_lower) {
  std::vector<Joint> joints;
  for (const auto& [name, lower] : {std::pair("shoulder", -1.5), {"elbow", elbow_lower}}) {
    joints.push_back(
        {.name = name, .axis = Eigen::Vector3d::UnitZ(), .lower = lower, .upper = 2.5, .velocity = 2, .effort = 10});
  }
  std::vector<Eigen::Isometry3d> fixed(3, Eigen::Isometry3d::Identity());
  fixed[1].translation().x() = 0.3;
  fixed[2].translation().x() = 0.2;
  return {joints, fixed, "base", "hand"};
}

TEST(ShortestPath, OfAPlanarArmIsTheStraightLineWhereTheArmCanFollowIt) {
  // With the elbow bent to one side, the hand covers the ring between two circles around the shoulder. A line between
  // two positions half way in it and a quarter turn apart stays inside.
  const Chain chain = planar_arm(0);
  const Roadmap roadmap(chain, 500, kSeed);
  ShortestPath shortest(chain, roadmap);
  const JointVector from = Eigen::Vector2d(-0.5, 1.2), to = Eigen::Vector2d(0.4, 1.2);
  const ReachSample sample{from, chain.position(to), to};
  const double distance = (chain.position(from) - chain.position(to)).norm();
  const auto length = shortest.length_m(sample);
  ASSERT_TRUE(length);
  EXPECT_GE(*length, distance * (1 - 1e-6));
  EXPECT_LE(*length, distance * 1.005);
}

TEST(ShortestPath, OfAPlanarArmLeadsAroundTheUnreachableDisc) {
  // The elbow bends by at most 2.5 rad: the hand cannot come nearer to the shoulder than r. Between two positions on
  // both sides, the shortest way is two tangents of that circle and an arc of it.
  const Chain chain = planar_arm(0);
  const double r = std::sqrt(0.3 * 0.3 + 0.2 * 0.2 + 2 * 0.3 * 0.2 * std::cos(2.5));
  const JointVector from = Eigen::Vector2d(-1.5, 2.2), to = Eigen::Vector2d(1.0, 2.2);
  const Eigen::Vector3d a = chain.position(from), b = chain.position(to);
  const double between = std::acos(a.dot(b) / (a.norm() * b.norm()));
  const double arc = between - std::acos(r / a.norm()) - std::acos(r / b.norm());
  ASSERT_GT(arc, 0.1) << "the straight line must be blocked";
  const double expected = std::sqrt(a.squaredNorm() - r * r) + std::sqrt(b.squaredNorm() - r * r) + arc * r;
  const Roadmap roadmap(chain, 500, kSeed);
  ShortestPath shortest(chain, roadmap);
  const auto length = shortest.length_m({from, b, to});
  ASSERT_TRUE(length);
  EXPECT_GE(*length, expected * (1 - 1e-6));
  EXPECT_LE(*length, expected * 1.02);
}

TEST(Straightness, NoWayIsShorterThanTheDistanceOrThanTheBoundOfTheOptimum) {
  const Chain chain = testing::hoap2();
  const auto reaches = run_straightness(chain, ReachSampler(chain, kSeed), 40, 500, 2);
  ASSERT_EQ(reaches.size(), 40);
  int dls_arrived = 0;
  for (size_t k = 0; k < reaches.size(); ++k) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", reach " + std::to_string(k));
    const StraightnessOf& reach = reaches[k];
    EXPECT_TRUE(reach.guarded.arrived && reach.planned.arrived);
    ASSERT_TRUE(reach.optimum_m);
    EXPECT_GE(*reach.optimum_m, reach.guarded.distance_m * (1 - 1e-6));
    dls_arrived += reach.dls.arrived;
    for (const ReachResult& one : {reach.guarded, reach.planned, reach.dls}) {
      EXPECT_LE(one.limit_excess, 1e-9);
      EXPECT_LE(one.velocity_excess, 1e-9);
      if (one.arrived) {
        EXPECT_LE(*reach.optimum_m, one.path_m + 1e-4);
      }
    }
  }
  EXPECT_GT(dls_arrived, 10);
  EXPECT_LT(dls_arrived, 40);
}

TEST(Straightness, DoesNotDependOnTheThreads) {
  const Chain chain = testing::hoap2();
  const ReachSampler sampler(chain, kSeed);
  const auto one = straightness_json(run_straightness(chain, sampler, 25, 300, 1));
  EXPECT_EQ(one, straightness_json(run_straightness(chain, sampler, 25, 300, 3)));
  EXPECT_NE(one, straightness_json(run_straightness(chain, ReachSampler(chain, kSeed + 1), 25, 300, 1)));
}

TEST(Straightness, QuantilesAreOfThoseThatArrived) {
  StraightnessOf arrives, fails;
  arrives.guarded = arrives.planned =
      arrives.dls = {.arrived = true, .distance_m = 0.1, .path_m = 0.12, .settled_step = 140};
  arrives.optimum_m = 0.11;
  fails = arrives;
  fails.dls.arrived = false;
  fails.guarded.path_m = 0.2;
  const auto result = straightness_json({arrives, fails});
  const auto& all = result.at("all");
  EXPECT_EQ(all.at("damped least squares").at("reaches"), 2);
  EXPECT_EQ(all.at("damped least squares").at("arrived"), 1);
  EXPECT_NEAR(all.at("guarded").at("path_ratio").at("p50"), 1.2, 1e-12);
  EXPECT_NEAR(all.at("guarded").at("path_ratio").at("p99"), 2.0, 1e-12);
  EXPECT_NEAR(all.at("guarded").at("settle_s").at("p50"), 1, 1e-12);
  const auto& some = result.at("where damped least squares arrives");
  EXPECT_EQ(some.at("guarded").at("reaches"), 1);
  EXPECT_NEAR(some.at("upper bound of the optimum").at("path_ratio").at("p50"), 1.1, 1e-12);
}

}  // namespace
}  // namespace multireach
