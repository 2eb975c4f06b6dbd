#include "vision/contour/gamma_shift.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::vision {
namespace {

// What the closed form misses, share of the shift: the blur, and the colours of both sides, are measured behind the
// curve; a window may hold less than the whole of a blurred edge. The first is set on the benchmark's balls
// (docs/vision-accuracy.md, the sets on which constants were set), the others on pictures as those of
// tests/vision/ball_picture.hpp.
constexpr double kMissed = 0.3, kMissedBlurred = 0.7;
constexpr double kBlurred2 = 1;     // px^2
constexpr double kSaturated = 250;  // grey levels: the light is not known

}  // namespace

// Of an edge between the light a^gamma and b^gamma, the grey level (b^gamma + c (a^gamma - b^gamma))^(1 / gamma) has
// the mean gamma / (gamma + 1) (a^(gamma + 1) - b^(gamma + 1)) / (a^gamma - b^gamma) over the shares c from 0 to 1,
// which is b + (a - b) (1/2 + shift).
GammaShift::GammaShift(std::optional<double> given) : gamma_(given) {
  const double gamma = given.value_or(kUsual);
  if (gamma == 1) return;
  for (int i = 0; i < kSteps; ++i) {
    const double ratio = static_cast<double>(i) / kSteps;
    const double mean = gamma / (gamma + 1) * (1 - std::pow(ratio, gamma + 1)) / (1 - std::pow(ratio, gamma));
    // Rounded, because pow() need not give the same last bits on another computer.
    constexpr double kDigits = 1 << 20;
    shifts_[static_cast<size_t>(i)] = std::round(kDigits * ((mean - ratio) / (1 - ratio) - 0.5)) / kDigits;
  }
}

double GammaShift::of_edge(double inside, double outside, double width_px) const {
  const double bright = std::max(inside, outside), dark = std::max(0.0, std::min(inside, outside));
  if (!(bright > dark)) return 0;
  const double position = kSteps * dark / bright;
  const int i = std::min(static_cast<int>(position), kSteps - 1);
  const double before = shifts_[static_cast<size_t>(i)], after = shifts_[static_cast<size_t>(i) + 1];
  const double shift = width_px * (before + (position - i) * (after - before));
  return inside > outside ? shift : -shift;
}

void GammaShift::correct(double blur2, bool hues_blurred, ContourEdgel& edgel) const {
  if (gamma_ == 1) return;
  Edge& edge = edgel.found;
  const double cosine = edgel.edge.cosine, tilt2 = 1 / (cosine * cosine) - 1;
  // The width of a box of the variance of the pixel's own width (1/12), the edge's slant and the blur together.
  const double width_px = std::sqrt(1 + tilt2 + 12 * std::max(0.0, blur2));
  double shift = 0;
  for (int k = 0; k < 3; ++k) {
    const double share = -edgel.edge.outward * edge.shading_gain[k] * (edge.rim[k] - edge.background[k]);
    shift += share * of_edge(edge.rim[k], edge.background[k], width_px);
  }
  const bool saturated = std::max(edge.rim.maxCoeff(), edge.background.maxCoeff()) > kSaturated;
  edge.gamma_rest_px = (saturated ? 1 : blur2 > kBlurred2 ? kMissedBlurred : kMissed) * shift;
  if (gamma_ && !hues_blurred) {
    edge.at -= edgel.edge.outward * shift;
  } else {
    edge.gamma_px = shift;
  }
}

}  // namespace multireach::vision
