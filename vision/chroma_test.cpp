#include "vision/chroma_test.hpp"

#include <algorithm>

#include "vision/natural_log.hpp"

namespace multireach::vision {

ChromaTest::ChromaTest(const ColourModel& model, const ColourShift& shift)
    : model_(model),
      shift_(shift),
      tolerance2_(model.tolerance * model.tolerance),
      variance_(model.noise_grey_levels * model.noise_grey_levels) {
  check(model);
  for (const ChromaComponent& component : model.object) object_.push_back(component_of(component));
  for (const ChromaComponent& component : model.background) background_.push_back(component_of(component));
}

ChromaTest::Component ChromaTest::component_of(const ChromaComponent& component) const {
  const Eigen::Matrix2d& C = component.covariance;
  Component result{component.mean.x(), component.mean.y(), C(0, 0), C(0, 1), C(1, 1), 0, colour_of(component.mean)};
  result.handicap = natural_log(C(0, 0) * C(1, 1) - C(0, 1) * C(0, 1)) - 2 * natural_log(component.weight);
  result.colour.r /= shift_.red;
  result.colour.b /= shift_.blue;
  return result;
}

double ChromaTest::distance2(const Component& component, const Chroma& chroma) {
  const double du = chroma.u - component.u, dv = chroma.v - component.v;
  const double uu = component.uu + chroma.uu, uv = component.uv + chroma.uv, vv = component.vv + chroma.vv;
  return (vv * du * du - 2 * uv * du * dv + uu * dv * dv) / (uu * vv - uv * uv);
}

ChromaTest::Chroma ChromaTest::chroma_of_pixel(double r, double g, double b) const {
  r *= shift_.red;
  b *= shift_.blue;
  const double y = 0.25 * (r + 2 * g + b), u = (r - g) / y, v = (b - g) / y;
  // The derivatives by the camera's R, G and B, times Y.
  const double ur = (1 - u / 4) * shift_.red, ug = -1 - u / 2, ub = -u / 4 * shift_.blue;
  const double vr = -v / 4 * shift_.red, vg = -1 - v / 2, vb = (1 - v / 4) * shift_.blue;
  const double scale = variance_ / (y * y);
  return {u, v, scale * (ur * ur + ug * ug + ub * ub), scale * (ur * vr + ug * vg + ub * vb),
          scale * (vr * vr + vg * vg + vb * vb)};
}

bool ChromaTest::fits(const Component& component, const Rgb& pixel) const {
  const bool clipped_r = pixel.r >= kClipped, clipped_g = pixel.g >= kClipped, clipped_b = pixel.b >= kClipped;
  double r = pixel.r, g = pixel.g, b = pixel.b;
  if (clipped_r || clipped_g || clipped_b) {
    // How bright the object is here, by least squares from the channels that are not clipped.
    const Rgb& colour = component.colour;
    double top = 0, bottom = 0;
    const auto count = [&](bool clipped, double value, double of_unit) {
      if (clipped) return;
      top += value * of_unit;
      bottom += of_unit * of_unit;
    };
    count(clipped_r, r, colour.r);
    count(clipped_g, g, colour.g);
    count(clipped_b, b, colour.b);
    const double y = bottom > 0 ? top / bottom : 0;
    if (clipped_r) r = std::max(r, y * colour.r);
    if (clipped_g) g = std::max(g, y * colour.g);
    if (clipped_b) b = std::max(b, y * colour.b);
  }
  const Chroma chroma = chroma_of_pixel(r, g, b);
  const double own = distance2(component, chroma);
  if (!(own <= tolerance2_)) return false;
  return std::ranges::none_of(background_, [&](const Component& other) {
    return distance2(other, chroma) + other.handicap < own + component.handicap;
  });
}

bool ChromaTest::contains(const Rgb& pixel) const {
  const double luma = luma_of(pixel);
  if (luma < model_.darkest || luma > model_.brightest || !(luma > 0)) return false;
  if (pixel.r >= kClipped && pixel.g >= kClipped && pixel.b >= kClipped) return false;
  return std::ranges::any_of(object_, [&](const Component& component) { return fits(component, pixel); });
}

size_t ChromaTest::nearest(const Rgb& pixel) const {
  const Chroma chroma = chroma_of_pixel(pixel.r, pixel.g, pixel.b);
  const auto distance = [&](const Component& component) { return distance2(component, chroma); };
  return static_cast<size_t>(std::ranges::min_element(object_, {}, distance) - object_.begin());
}

}  // namespace multireach::vision
