#include "studies/tracking/tracking.hpp"

#include <gtest/gtest.h>

#include "tests/test_arms.hpp"

namespace multireach {
namespace {

const TrackedPath kCircle{"circle", 2, false};

JointVector bent(const Chain& chain) {
  JointVector theta = (chain.lower() + chain.upper()) / 2;
  theta[chain.size() - 1] = chain.lower()[chain.size() - 1] / 2;
  return theta;
}

TEST(Tracking, TheVelocityOfAPathIsTheDerivativeOfItsPosition) {
  constexpr double kStep = 1e-5;  // s; central differences err by its square times the third derivative, 50 m/s^3
  for (const TrackedPath& path : {kCircle, TrackedPath{"8", 0.5, true}}) {
    for (double t = 0; t < 2; t += 0.13) {
      const Eigen::Vector3d difference = (path.position(t + kStep, 0.1) - path.position(t - kStep, 0.1)) / (2 * kStep);
      EXPECT_LT((difference - path.velocity(t, 0.1)).norm(), 1e-6);
    }
  }
}

TEST(Tracking, ATargetThatHardlyMovesIsReached) {
  const Chain chain = testing::hoap2();
  for (const Tracker tracker : {Tracker::kReach, Tracker::kTrack, Tracker::kFollower}) {
    const auto error = run_tracking(chain, bent(chain), kCircle, 1e-6, tracker, true);
    ASSERT_TRUE(error);
    EXPECT_LT(error->max_m, 1e-5);
  }
}

constexpr double kLatency = 0.03;  // s: from the image to the motion

// A target without velocity is known where it was when its image was taken. What does not extrapolate it is behind by
// the time to the motion at least. With its velocity, each does better.
TEST(Tracking, WithoutTheTargetsVelocityTheHandIsBehind) {
  const Chain chain = testing::hoap2();
  for (const Tracker tracker : {Tracker::kReach, Tracker::kFollower}) {
    const auto without = run_tracking(chain, bent(chain), kCircle, 0.01, tracker, false);
    const auto with = run_tracking(chain, bent(chain), kCircle, 0.01, tracker, true);
    ASSERT_TRUE(without && with);
    EXPECT_GT(without->lag_s, kLatency);
    EXPECT_LT(with->lag_s, without->lag_s);
    EXPECT_LT(with->rms_m, without->rms_m);
  }
}

TEST(Tracking, MotionTrackEstimatesTheVelocity) {
  // Nearer to the target than anything can be that does not extrapolate: the target moves so far until the motion.
  const Chain chain = testing::hoap2();
  constexpr double kRadius = 0.01;
  const auto without = run_tracking(chain, bent(chain), kCircle, kRadius, Tracker::kTrack, false);
  ASSERT_TRUE(without);
  EXPECT_LT(std::abs(without->lag_s), kLatency);
  EXPECT_LT(without->rms_m, kCircle.velocity(0, kRadius).norm() * kLatency);
}

TEST(Tracking, APathOutOfReachIsNotTracked) {
  const Chain chain = testing::hoap2();
  EXPECT_FALSE(run_tracking(chain, bent(chain), kCircle, 10, Tracker::kReach, true));
}

}  // namespace
}  // namespace multireach
