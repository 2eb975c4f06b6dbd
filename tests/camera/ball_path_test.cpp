#include "camera/rendering/ball_path.hpp"

#include <gtest/gtest.h>

namespace multireach {
namespace {

Config scene(const std::string& path) {
  return Config::parse("scene.yaml", "path: " + path);
}

// Second differences of the position are the acceleration of free fall; the throw begins and ends where it should.
TEST(BallPath, AThrownBallFallsFreely) {
  const BallPath path(scene("[{at_s: 0, position_m: [1, 0, 0.2]}, {at_s: 2, throw_to_m: [0, 0.4, 0.1], over_s: 0.5}]"));
  const Eigen::Vector3d from(1, 0, 0.2), to(0, 0.4, 0.1);
  EXPECT_EQ(path.position(2), from);
  EXPECT_LT((path.position(2.5) - to).norm(), 1e-15);
  EXPECT_EQ(path.position(3), path.position(2.5));
  constexpr double kStep = 0.01;
  for (double t = 2 + kStep; t < 2.5 - kStep; t += kStep) {
    const Eigen::Vector3d acceleration =
        (path.position(t + kStep) - 2 * path.position(t) + path.position(t - kStep)) / (kStep * kStep);
    EXPECT_LT((acceleration - Eigen::Vector3d(0, 0, -9.81)).norm(), 1e-10);
  }
}

TEST(BallPath, AMovementIsOneOfThree) {
  EXPECT_THROW(
      BallPath(scene("[{at_s: 0, position_m: [1, 0, 0]}, {at_s: 1, move_to_m: [0, 0, 0], throw_to_m: [0, 0, 0], "
                     "over_s: 1}]")),
      InputError);
  EXPECT_THROW(BallPath(scene("[{at_s: 0, position_m: [1, 0, 0]}, {at_s: 1, throw_to_m: [0, 0, 0]}]")), InputError);
}

}  // namespace
}  // namespace multireach
