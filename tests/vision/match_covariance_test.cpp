// The covariance of a stereo match, over random measurements.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "numeric/gaussian.hpp"
#include "numeric/random.hpp"
#include "vision/stereo/compare_contours.hpp"

namespace multireach::vision {
namespace {

using Kind = SphereContour::Kind;

constexpr double kRadius = 0.03;

class Draws {
 public:
  explicit Draws(uint64_t seed) : random_(seed) {}
  double uniform(double from, double to) { return random_.uniform(counter_++, from, to); }
  double normal() { return gaussian(random_, counter_); }
  bool coin() { return uniform(0, 1) < 0.5; }

 private:
  CounterRandom random_;
  uint64_t counter_ = 0;
};

/// What one camera measures of a sphere: a contour, or the centroid of a blob that shows a part of it.
SphereContour measured(const CameraModel& camera, const Eigen::Vector3d& p_C, Draws& draws) {
  SphereContour contour;
  contour.kind = draws.coin() ? Kind::kEdges : Kind::kCentroid;
  const bool edges = contour.kind == Kind::kEdges;
  const double direction = (edges ? draws.uniform(0.03, 0.3) : draws.uniform(0.5, 4)) / camera.fx;
  const double size = (edges ? draws.uniform(0.03, 0.3) : draws.uniform(1, 5)) / camera.fx;
  contour.value << p_C.hnormalized(), kRadius / p_C.norm();
  contour.value += Eigen::Vector3d(direction * draws.normal(), direction * draws.normal(), size * draws.normal());
  if (!edges) contour.value.z() *= draws.uniform(0.75, 1.1);
  contour.covariance = Eigen::Vector3d(direction * direction, direction * direction, size * size).asDiagonal();
  if (edges) contour.from_centroid = 3 * direction * Eigen::Vector3d(draws.normal(), draws.normal(), draws.normal());
  contour.centre_px = camera.project(contour.ray().homogeneous());
  contour.radius_px = contour.value.z() * camera.fx;
  contour.area = M_PI * contour.radius_px * contour.radius_px;
  contour.visible_fraction = edges ? 1 : 0;
  return contour;
}

TEST(MatchCovariance, IsPositiveDefinite) {
  constexpr uint64_t kSeed = 41;
  constexpr int kPairs = 100000;
  Draws draws(kSeed);
  StereoRig rig = parallel_rig(640, 480, 500, 0.06);
  rig.X_WL.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  int seen = 0;
  for (int k = 0; k < kPairs; ++k) {
    const Eigen::Vector3d p_L(draws.uniform(-0.3, 0.3), draws.uniform(-0.2, 0.2), draws.uniform(0.4, 2));
    const bool known = draws.coin();
    const SphereContour left = measured(rig.left, p_L, draws), right = measured(rig.right, rig.X_RL * p_L, draws);
    const ComparedPair pair = compare_contours(rig, left, right, std::nullopt, {.radius_m = known ? kRadius : 0});
    if (pair.match.status != StereoMatch::Status::kSeen) continue;
    ++seen;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(pair.match.covariance(), Eigen::EigenvaluesOnly);
    ASSERT_GT(solver.eigenvalues().minCoeff(), 0)
        << "seed " << kSeed << ", pair " << k << (known ? ", known radius\n" : "\n") << pair.match.covariance();
  }
  EXPECT_GT(seen, kPairs / 4);
}

}  // namespace
}  // namespace multireach::vision
