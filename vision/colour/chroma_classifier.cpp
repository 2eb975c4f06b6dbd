#include "vision/colour/chroma_classifier.hpp"

#include <algorithm>
#include <cmath>

#include "numeric/natural_log.hpp"

namespace multireach::vision {

ChromaClassifier::ChromaClassifier(const ColourModel& model, const WhiteBalanceGains& gains)
    : model_(model),
      tolerance2_(model.tolerance * model.tolerance),
      variance_(model.noise_grey_levels * model.noise_grey_levels) {
  check(model);
  for (const ChromaComponent& component : model.object) object_.push_back(component_of(component));
  for (const ChromaComponent& component : model.background) background_.push_back(component_of(component));
  set_gains(gains);
}

void ChromaClassifier::set_gains(const WhiteBalanceGains& gains) {
  gains_ = gains;
  // Bounds the variance of Y times U or V: the derivatives are |1 - U/4| <= 1.5, |1 + U/2| <= 3, |U/4| <= 1, times the
  // gains.
  largest_variance_ = variance_ * 12.25 * std::max({1.0, gains.red * gains.red, gains.blue * gains.blue});
}

ChromaClassifier::Component ChromaClassifier::component_of(const ChromaComponent& component) {
  const Eigen::Matrix2d& C = component.covariance;
  const double handicap = natural_log(C(0, 0) * C(1, 1) - C(0, 1) * C(0, 1)) - 2 * natural_log(component.weight);
  return {component.mean.x(), component.mean.y(), C(0, 0), C(0, 1), C(1, 1), handicap, colour_of(component.mean)};
}

double ChromaClassifier::distance2(const Component& component, const Chroma& chroma) {
  const double du = chroma.u - component.u, dv = chroma.v - component.v;
  const double uu = component.uu + chroma.uu, uv = component.uv + chroma.uv, vv = component.vv + chroma.vv;
  return (vv * du * du - 2 * uv * du * dv + uu * dv * dv) / (uu * vv - uv * uv);
}

ChromaClassifier::Chroma ChromaClassifier::chroma_of_pixel(double r, double g, double b) const {
  r *= gains_.red;
  b *= gains_.blue;
  const double y = 0.25 * (r + 2 * g + b), u = (r - g) / y, v = (b - g) / y;
  // Derivatives with respect to the camera's R, G and B, times Y.
  const double ur = (1 - u / 4) * gains_.red, ug = -1 - u / 2, ub = -u / 4 * gains_.blue;
  const double vr = -v / 4 * gains_.red, vg = -1 - v / 2, vb = (1 - v / 4) * gains_.blue;
  const double scale = variance_ / (y * y);
  return {u, v, scale * (ur * ur + ug * ug + ub * ub), scale * (ur * vr + ug * vg + ub * vb),
          scale * (vr * vr + vg * vg + vb * vb)};
}

bool ChromaClassifier::may_fit(const Component& component, const Rgb& pixel) const {
  const double r = pixel.r * gains_.red, b = pixel.b * gains_.blue, y = 0.25 * (r + 2 * pixel.g + b);
  const double du = r - pixel.g - component.u * y, dv = b - pixel.g - component.v * y;  // times Y, to avoid a division
  return du * du <= tolerance2_ * (component.uu * y * y + largest_variance_) &&
         dv * dv <= tolerance2_ * (component.vv * y * y + largest_variance_);
}

Rgb ChromaClassifier::unclipped(const Component& component, const Rgb& pixel) const {
  // Estimate the object's brightness by least squares from the channels that are not clipped.
  const Rgb colour{component.colour.r / gains_.red, component.colour.g, component.colour.b / gains_.blue};
  double top = 0, bottom = 0;
  const auto count = [&](double value, double of_unit) {
    if (value >= kClipped) return;
    top += value * of_unit;
    bottom += of_unit * of_unit;
  };
  count(pixel.r, colour.r);
  count(pixel.g, colour.g);
  count(pixel.b, colour.b);
  const double y = bottom > 0 ? top / bottom : 0;
  const auto above = [&](double value, double of_unit) {
    return value >= kClipped ? std::max(value, y * of_unit) : value;
  };
  return {above(pixel.r, colour.r), above(pixel.g, colour.g), above(pixel.b, colour.b)};
}

bool ChromaClassifier::fits(const Component& component, Rgb pixel) const {
  if (pixel.r >= kClipped || pixel.g >= kClipped || pixel.b >= kClipped) {
    pixel = unclipped(component, pixel);
    // Otherwise near-white pixels would belong to any colour: with the clipped channel as bright as it takes.
    constexpr double kBrightest = 360;  // three times as bright as an object of Y = 120
    if (luma_of(pixel) > kBrightest) return false;
  }
  if (!may_fit(component, pixel)) return false;
  const Chroma chroma = chroma_of_pixel(pixel.r, pixel.g, pixel.b);
  const double own = distance2(component, chroma);
  if (!(own <= tolerance2_)) return false;
  return std::ranges::none_of(background_, [&](const Component& other) {
    return distance2(other, chroma) + other.handicap < own + component.handicap;
  });
}

bool ChromaClassifier::contains(const Rgb& pixel) const {
  const double luma = luma_of(pixel);
  if (luma < model_.min_luma || luma > model_.max_luma) return false;
  if (!(luma > 0)) return true;  // min_luma is 0: black pixels belong, although their chroma is undefined
  if (pixel.r >= kClipped && pixel.g >= kClipped && pixel.b >= kClipped) return false;
  return std::ranges::any_of(object_, [&](const Component& component) { return fits(component, pixel); });
}

double ChromaClassifier::deviation(const Rgb& colour) const {
  if (object_.size() > 1) return 0;
  Chroma chroma = chroma_of_pixel(colour.r, colour.g, colour.b);
  chroma.uu = chroma.uv = chroma.vv = 0;
  return std::sqrt(distance2(object_.front(), chroma));
}

Rgb ChromaClassifier::expected(const Rgb& pixel) const {
  const Chroma chroma = chroma_of_pixel(pixel.r, pixel.g, pixel.b);
  const auto distance = [&](const Component& component) { return distance2(component, chroma); };
  const Rgb& colour = std::ranges::min_element(object_, {}, distance)->colour;
  const double y = luma_of({pixel.r * gains_.red, pixel.g, pixel.b * gains_.blue});
  return {y * colour.r, y * colour.g, y * colour.b};
}

}  // namespace multireach::vision
