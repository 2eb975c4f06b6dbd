#include "imaging/camera_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "numeric/random.hpp"

namespace multireach::vision {
namespace {

CameraModel camera() {
  return {.width = 320,
          .height = 240,
          .fx = 300,
          .fy = 301,
          .cx = 160.7,
          .cy = 118.9,
          .distortion = {-0.25, 0.06, 0.0008, -0.0005}};
}

TEST(CameraModel, ProjectsByTheFormula) {
  const CameraModel c = camera();
  const double x = 0.2, y = -0.1, r2 = x * x + y * y;
  const double radial = 1 - 0.25 * r2 + 0.06 * r2 * r2, p1 = 0.0008, p2 = -0.0005;
  const double u = 300 * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + 160.7;
  const double v = 301 * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + 118.9;
  EXPECT_TRUE(c.project(Eigen::Vector3d(x, y, 1) * 0.7).isApprox(Eigen::Vector2d(u, v), 1e-12));
}

TEST(CameraModel, ThePrincipalPointIsOnTheAxis) {
  // The centre of the first pixel is at (0, 0), so there is no offset of half a pixel.
  const CameraModel c = camera();
  EXPECT_TRUE(c.project({0, 0, 2}).isApprox(Eigen::Vector2d(160.7, 118.9), 1e-12));
}

TEST(CameraModel, RayIsTheInverseOfProject) {
  const CameraModel c = camera();
  const CounterRandom random(5);
  for (uint64_t k = 0; k < 500; ++k) {
    const Eigen::Vector2d pixel(random.uniform(2 * k, 0, 319), random.uniform(2 * k + 1, 0, 239));
    const Eigen::Vector2d ray = c.ray(pixel);
    EXPECT_LT((c.project(ray.homogeneous()) - pixel).norm(), 1e-6) << pixel.transpose();
  }
}

TEST(CameraModel, RayIsTheInverseForWideLensesToo) {
  // Radial coefficients with which dividing the distortion out diverges at the given radius.
  struct Wide {
    double k1, k2, k3, radius;
  };
  for (const Wide& wide :
       {Wide{0.1, 0.5, 0.5, 0.78}, Wide{-0.2, 0.8, 2.0, 0.7}, Wide{-0.28, 0.08, 0.3, 1.09}, Wide{0.5, 0, 0, 1.04}}) {
    CameraModel c = camera();
    c.distortion = {wide.k1, wide.k2, 0, 0, wide.k3};
    for (const double angle : {0.0, 0.8, 2.5, 4.0}) {
      const Eigen::Vector2d ray = wide.radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d pixel = c.project({ray.x(), ray.y(), 1});
      EXPECT_LT((c.ray(pixel) - ray).norm(), 1e-9) << wide.k1 << " " << wide.k2 << " " << wide.k3 << " at " << angle;
    }
  }
}

}  // namespace
}  // namespace multireach::vision
