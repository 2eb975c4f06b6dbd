#include "imaging/lens.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <vector>

#include "numeric/instruction_set.hpp"

namespace multireach::vision {
namespace {

const CameraModel kCamera{.width = 640,
                          .height = 480,
                          .fx = 500,
                          .fy = 503,
                          .cx = 322,
                          .cy = 238,
                          .distortion = {-0.3, 0.12, 0.001, -0.0007, -0.02, 0.01, 0.002, 0.001}};

TEST(Lens, IsTheProjectionOfOpenCvWithItsDerivative) {
  for (const Eigen::Vector2d& ray : {Eigen::Vector2d(0, 0), {0.3, -0.2}, {-0.5, 0.4}}) {
    const LensPoint point = image_of(kCamera, ray);
    EXPECT_LT((point.pixel - kCamera.project(ray.homogeneous())).norm(), 1e-9);
    constexpr double kStep = 1e-6;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
      const Eigen::Vector2d slope =
          (image_of(kCamera, ray + step).pixel - image_of(kCamera, ray - step).pixel) / (2 * kStep);
      EXPECT_LT((point.d_pixel_d_ray.col(axis) - slope).norm(), 1e-5);
    }
  }
}

TEST(Lens, RaysAreTheInverse) {
  for (double x = 0; x < kCamera.width; x += 71) {
    for (double y = 0; y < kCamera.height; y += 53) {
      const Eigen::Vector2d pixel(x, y), ray = ray_of(kCamera, pixel, {0, 0});
      EXPECT_LT((image_of(kCamera, ray).pixel - pixel).norm(), 1e-9);
      EXPECT_LT((ray - kCamera.ray(pixel)).norm(), 1e-7);
    }
  }
}

TEST(Lens, RaysOfSeveralPixelsAreThoseOfEach) {
  std::vector<Eigen::Vector2d> pixels;
  for (int k = 0; k < 21; ++k) pixels.emplace_back(30 * k, 479 - 23 * k);
  for (const std::string& name : available_instruction_sets()) {
    ASSERT_TRUE(select_instruction_set(name));
    std::vector<Eigen::Vector2d> rays(pixels.size(), Eigen::Vector2d(0, 0));
    rays_of(kCamera, pixels, rays);
    for (size_t k = 0; k < pixels.size(); ++k) {
      EXPECT_EQ(rays[k], ray_of(kCamera, pixels[k], {0, 0})) << name;
      EXPECT_LT((image_of(kCamera, rays[k]).pixel - pixels[k]).norm(), 1e-9) << name;
    }
  }
  select_instruction_set("");
}

}  // namespace
}  // namespace multireach::vision
