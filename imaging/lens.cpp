#include "imaging/lens.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "imaging/lens.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "numeric/wide_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach {
namespace HWY_NAMESPACE {

#include "imaging/lens.inl.hpp"

/// Newton steps from x and y, the rays of pixels nearby, to the rays of the pixels px and py, in the first `count`
/// lanes.
void refine_rays(const CameraModel& camera, int count, const Row& px, const Row& py, Row& x, Row& y) {
  constexpr int kSteps = 20;  // three or four suffice from a start nearby
  for (int first = 0; first < count; first += kWidth) {
    const Lanes target_x = load(px, first), target_y = load(py, first);
    Lanes ray_x = load(x, first), ray_y = load(y, first);
    LanesMask open = !no_lane();
    for (int step = 0; step < kSteps && any(open); ++step) {
      const PixelOfRay<Lanes> at(camera, ray_x, ray_y);
      const Lanes inverse = 1 / (at.dpx_dx * at.dpy_dy - at.dpy_dx * at.dpx_dy);
      const Lanes dx = target_x - at.px, dy = target_y - at.py;
      const Lanes move_x = at.dpy_dy * inverse * dx + -at.dpx_dy * inverse * dy;
      const Lanes move_y = -at.dpy_dx * inverse * dx + at.dpx_dx * inverse * dy;
      ray_x = where(open, ray_x + move_x, ray_x);
      ray_y = where(open, ray_y + move_y, ray_y);
      // Converges quadratically: the next step would be negligible.
      open = open & !(move_x * move_x + move_y * move_y < 1e-16);
    }
    store(ray_x, x, first);
    store(ray_y, y, first);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace multireach {

HWY_EXPORT(refine_rays);

namespace {
#include "imaging/lens.inl.hpp"
}  // namespace

LensPoint image_of(const CameraModel& camera, const Eigen::Vector2d& ray) {
  const PixelOfRay<double> at(camera, ray.x(), ray.y());
  LensPoint point;
  point.pixel = {at.px, at.py};
  point.d_pixel_d_ray << at.dpx_dx, at.dpx_dy, at.dpy_dx, at.dpy_dy;
  return point;
}

void rays_of(const CameraModel& camera, std::span<const Eigen::Vector2d> pixels, std::span<Eigen::Vector2d> rays) {
  for (size_t begin = 0; begin < pixels.size(); begin += kRowLanes) {
    const size_t count = std::min<size_t>(kRowLanes, pixels.size() - begin);
    Row px, py, x, y;
    for (size_t lane = 0; lane < kRowLanes; ++lane) {
      const size_t from = begin + std::min(lane, count - 1), to = lane;
      px.lane[to] = pixels[from].x();
      py.lane[to] = pixels[from].y();
      x.lane[to] = rays[from].x();
      y.lane[to] = rays[from].y();
    }
    HWY_DYNAMIC_DISPATCH(refine_rays)(camera, static_cast<int>(count), px, py, x, y);
    for (size_t lane = 0; lane < count; ++lane) rays[begin + lane] = {x.lane[lane], y.lane[lane]};
  }
}

Eigen::Vector2d ray_of(const CameraModel& camera, const Eigen::Vector2d& pixel, const Eigen::Vector2d& near) {
  Eigen::Vector2d ray = near;
  rays_of(camera, {&pixel, 1}, {&ray, 1});
  return ray;
}

}  // namespace multireach
#endif
