#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "imaging/stereo_rig.hpp"
#include "numeric/random.hpp"
#include "tests/vision/mask_blobs.hpp"

// Pictures of balls, rendered here, independently of what measures them.
namespace multireach::vision {

inline CameraModel camera(bool distorted = false) {
  CameraModel camera{
      .width = 320, .height = 240, .fx = 300, .fy = 301, .cx = 158, .cy = 121, .distortion = {}, .gamma = 1};
  if (distorted) camera.distortion = {-0.3, 0.1, 0.001, -0.0008, 0, 0, 0, 0};
  return camera;
}

struct Scene {
  Eigen::Vector3d ball_rgb{210, 50, 60}, wall_rgb{100, 110, 120};
  double noise = 0;
  Eigen::Vector3d light{0, 0, 0};  // direction to a distant light; none: the ball has the same colour everywhere
  std::function<bool(double, double)> hides = [](double, double) { return false; };  // pixels
  Eigen::Vector3d hiding_rgb{60, 120, 70};
  Eigen::Vector3d stripe_axis{0, 0, 0};  // of a white band along a great circle; none
  double dark_from = 1e9;                // column from which on the wall has a fifth of its grey levels
  double gamma = 1;                      // of the camera; the colours are grey levels, and light mixes in pixels
};

inline Eigen::Vector3d light_of(const Scene& scene, const Eigen::Vector3d& rgb) {
  return scene.gamma == 1 ? rgb : Eigen::Vector3d(255 * (rgb / 255).array().pow(scene.gamma));
}

/// The ball's colour where the direction `e` meets it: matt, with a third of its light from everywhere.
inline Eigen::Vector3d colour_at(const Scene& scene, const Eigen::Vector3d& p_CB, double radius,
                                 const Eigen::Vector3d& e) {
  if (scene.light.isZero()) return scene.ball_rgb;
  constexpr double kHalfWidth = 0.15;  // of the band, share of the radius
  const double along = e.dot(p_CB), beside2 = p_CB.squaredNorm() - along * along;
  const Eigen::Vector3d normal = (e * (along - std::sqrt(std::max(0.0, radius * radius - beside2))) - p_CB) / radius;
  const bool white = !scene.stripe_axis.isZero() && std::abs(normal.dot(scene.stripe_axis)) < kHalfWidth;
  return (white ? Eigen::Vector3d(230, 230, 225) : scene.ball_rgb) * (1 + 2 * std::max(0.0, normal.dot(scene.light))) /
         3;
}

/// The picture of a sphere of one colour: a pixel's colour is the mean over 8 x 8 rays, each of which
/// either hits the sphere or misses it.
inline cv::Mat picture(const CameraModel& camera, const Eigen::Vector3d& p_CB, double radius, const Scene& scene) {
  cv::Mat image(camera.height, camera.width, CV_8UC3);
  const CounterRandom random(5);
  uint64_t counter = 0;
  constexpr int kGrid = 8;
  const Eigen::Vector2d middle = camera.project(p_CB);
  const double near = 1.6 * camera.fx * radius / (p_CB.z() - radius) + 3;
  const auto wall = [&](double x) -> Eigen::Vector3d { return (x < scene.dark_from ? 1 : 0.2) * scene.wall_rgb; };
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      if ((Eigen::Vector2d(column, row) - middle).norm() > near) {
        sum = kGrid * kGrid * light_of(scene, scene.hides(column, row) ? scene.hiding_rgb : wall(column));
      } else {
        std::vector<Eigen::Vector2d> pixels;
        for (int k = 0; k < kGrid * kGrid; ++k)
          pixels.emplace_back(column + (k % kGrid + 0.5) / kGrid - 0.5, row + (k / kGrid + 0.5) / kGrid - 0.5);
        const std::vector<Eigen::Vector2d> rays = camera.rays(pixels);
        for (size_t k = 0; k < rays.size(); ++k) {
          const Eigen::Vector3d e = rays[k].homogeneous().normalized();
          const bool ball = (p_CB - e * e.dot(p_CB)).norm() < radius;
          const bool hidden = scene.hides(pixels[k].x(), pixels[k].y());
          sum += light_of(scene, hidden ? scene.hiding_rgb
                                 : ball ? colour_at(scene, p_CB, radius, e)
                                        : wall(pixels[k].x()));
        }
      }
      for (int channel = 0; channel < 3; ++channel) {
        // The sum of twelve uniform numbers, minus six, is about normal with unit variance.
        double normal = -6;
        for (int k = 0; k < 12 && scene.noise > 0; ++k) normal += random.uniform(counter++);
        const double mean = sum[2 - channel] / (kGrid * kGrid);
        const double grey = scene.gamma == 1 ? mean : 255 * std::pow(mean / 255, 1 / scene.gamma);
        const double value = grey + (scene.noise > 0 ? scene.noise * normal : 0);
        image.at<cv::Vec3b>(row, column)[channel] = static_cast<uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
      }
    }
  }
  return image;
}

/// The blobs of pixels that have about the ball's colour.
inline std::vector<Blob> red_blobs(const cv::Mat& image) {
  cv::Mat mask(image.size(), CV_8UC1);
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      const auto& bgr = image.at<cv::Vec3b>(row, column);
      mask.at<uint8_t>(row, column) = bgr[2] > 2 * bgr[1] - 10 ? 255 : 0;
    }
  }
  return blobs_of(mask, 20);
}

}  // namespace multireach::vision
