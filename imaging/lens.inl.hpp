// Include inside a namespace, after camera_model.hpp. `Lanes` is double or SIMD lanes.

/// image_of(): the pixel, and its derivative with respect to the direction (x, y), by rows.
template <class Lanes>
struct PixelOfRay {
  Lanes px, py, dpx_dx, dpx_dy, dpy_dx, dpy_dy;

  PixelOfRay(const CameraModel& camera, Lanes x, Lanes y) {
    const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = camera.distortion;
    const Lanes r2 = x * x + y * y;
    const Lanes above = 1 + r2 * (k1 + r2 * (k2 + r2 * k3)), below = 1 + r2 * (k4 + r2 * (k5 + r2 * k6));
    const Lanes radial = above / below;
    const Lanes slope =
        ((k1 + r2 * (2 * k2 + r2 * 3 * k3)) - radial * (k4 + r2 * (2 * k5 + r2 * 3 * k6))) / below;  // d radial / d r2
    px = camera.fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + camera.cx;
    py = camera.fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + camera.cy;
    const Lanes across = 2 * (x * y * slope + p1 * x + p2 * y);
    dpx_dx = camera.fx * (radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x);
    dpx_dy = camera.fx * across;
    dpy_dx = camera.fy * across;
    dpy_dy = camera.fy * (radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x);
  }
};
