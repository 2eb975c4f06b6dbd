#include "vision/colour/chroma_classifier.hpp"

#include <algorithm>
#include <cmath>

#include "numeric/natural_log.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/colour/chroma_classifier.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "numeric/wide_lanes-inl.hpp"

namespace multireach::vision {
using BlueRows = std::array<Row, 32 / kRowLanes>;
}  // namespace multireach::vision

HWY_BEFORE_NAMESPACE();
namespace multireach::vision {
namespace HWY_NAMESPACE {

using multireach::HWY_NAMESPACE::any;
using multireach::HWY_NAMESPACE::greater;
using multireach::HWY_NAMESPACE::kWidth;
using multireach::HWY_NAMESPACE::Lanes;
using multireach::HWY_NAMESPACE::load;
using multireach::HWY_NAMESPACE::where;

#include "vision/colour/chroma_criterion.inl.hpp"

uint32_t contains_blues(const ChromaCriterion& criterion, double red, double green, const BlueRows& blues) {
  uint32_t bits = 0;
  for (size_t row = 0; row < blues.size(); ++row) {
    for (int first = 0; first < kRowLanes; first += kWidth) {
      const PixelOf<Lanes> pixel{red, green, load(blues[row], first)};
      bits |= bits_of(contains(criterion, pixel)) << (static_cast<int>(row) * kRowLanes + first);
    }
  }
  return bits;
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach::vision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace multireach::vision {

HWY_EXPORT(contains_blues);

namespace {

#include "vision/colour/chroma_criterion.inl.hpp"

ChromaCriterion::Component component_of(const ChromaComponent& component) {
  const Eigen::Matrix2d& C = component.covariance;
  const double handicap = natural_log(C(0, 0) * C(1, 1) - C(0, 1) * C(0, 1)) - 2 * natural_log(component.weight);
  return {component.mean.x(), component.mean.y(), C(0, 0), C(0, 1), C(1, 1), handicap, colour_of(component.mean)};
}

}  // namespace

ChromaClassifier::ChromaClassifier(const ColourModel& model, const WhiteBalanceGains& gains)
    : criterion_{.object = {},
                 .background = {},
                 .gains = gains,
                 .min_luma = model.min_luma,
                 .max_luma = model.max_luma,
                 .tolerance2 = model.tolerance * model.tolerance,
                 .variance = model.noise_grey_levels * model.noise_grey_levels,
                 .largest_variance = 0} {
  check(model);
  for (const ChromaComponent& component : model.object) criterion_.object.push_back(component_of(component));
  for (const ChromaComponent& component : model.background) criterion_.background.push_back(component_of(component));
  set_gains(gains);
}

void ChromaClassifier::set_gains(const WhiteBalanceGains& gains) {
  criterion_.gains = gains;
  // Bounds the variance of Y times U or V: the derivatives are |1 - U/4| <= 1.5, |1 + U/2| <= 3, |U/4| <= 1, times the
  // gains.
  criterion_.largest_variance =
      criterion_.variance * 12.25 * std::max({1.0, gains.red * gains.red, gains.blue * gains.blue});
}

bool ChromaClassifier::contains(const Rgb& pixel) const {
  return vision::contains(criterion_, PixelOf<double>{pixel.r, pixel.g, pixel.b});
}

bool ChromaClassifier::contains_as_read(const Rgb& pixel) const {
  return vision::contains(criterion_, PixelOf<double>{pixel.r, pixel.g, pixel.b}, true);
}

uint32_t ChromaClassifier::contains(double red, double green, const std::array<double, 32>& blues) const {
  BlueRows rows;
  for (size_t k = 0; k < blues.size(); ++k) rows[k / kRowLanes].lane[k % kRowLanes] = blues[k];
  return HWY_DYNAMIC_DISPATCH(contains_blues)(criterion_, red, green, rows);
}

double ChromaClassifier::deviation(const Rgb& colour) const {
  if (criterion_.object.size() > 1) return 0;
  ChromaOf<double> chroma(criterion_, {colour.r, colour.g, colour.b});
  chroma.uu = chroma.uv = chroma.vv = 0;
  return std::sqrt(chroma.distance2(criterion_.object.front()));
}

Rgb ChromaClassifier::expected(const Rgb& pixel) const {
  const ChromaOf<double> chroma(criterion_, {pixel.r, pixel.g, pixel.b});
  const auto distance2 = [&](const ChromaCriterion::Component& component) { return chroma.distance2(component); };
  const Rgb& colour = std::ranges::min_element(criterion_.object, {}, distance2)->colour;
  const double y = luma_of({pixel.r * criterion_.gains.red, pixel.g, pixel.b * criterion_.gains.blue});
  return {y * colour.r, y * colour.g, y * colour.b};
}

}  // namespace multireach::vision
#endif
