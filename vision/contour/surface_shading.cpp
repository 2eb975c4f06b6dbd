#include "vision/contour/surface_shading.hpp"

#include <algorithm>

#include "numeric/median.hpp"

namespace multireach::vision {
namespace {

constexpr double kAnyPaint = 1e3;  // grey levels: no two colours are as far apart

}  // namespace

void SurfaceShading::clear() {
  shading_.clear();
  other_paint_ = kAnyPaint;
}

void SurfaceShading::fit(std::span<const SurfaceColour> surface, bool plain) {
  clear();
  shading_.fit(surface);
  if (plain || surface.empty()) return;
  constexpr int kRounds = 4;
  // Noise, and what shading of second order cannot represent, stay well below this many medians, and grey levels.
  constexpr double kMedians = 4, kLeast = 20;
  for (int round = 0; round < kRounds; ++round) {
    apart_.clear();
    for (const SurfaceColour& point : surface) apart_.push_back((point.bgr() - shading_.colour(point.terms())).norm());
    sorted_ = apart_;
    other_paint_ = std::max(kLeast, kMedians * median_of(sorted_));
    if (*std::ranges::max_element(apart_) <= other_paint_) break;
    same_paint_.clear();
    for (size_t i = 0; i < surface.size(); ++i) {
      if (apart_[i] <= other_paint_) same_paint_.push_back(surface[i]);
    }
    shading_.fit(same_paint_);
  }
}

double SurfaceShading::most_apart(double noise) const {
  constexpr double kSigmas = 3;
  return other_paint_ + kSigmas * noise;
}

}  // namespace multireach::vision
