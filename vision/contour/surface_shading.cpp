#include "vision/contour/surface_shading.hpp"

#include <algorithm>

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
  for (const SurfaceColour& point : surface) shading_.add(point.normal, point.bgr);
  shading_.solve();
  if (plain || surface.empty()) return;
  constexpr int kRounds = 4;
  // Noise, and what shading of second order cannot represent, stay well below this many medians, and grey levels.
  constexpr double kMedians = 4, kLeast = 20;
  for (int round = 0; round < kRounds; ++round) {
    apart_.clear();
    for (const SurfaceColour& point : surface)
      apart_.push_back((point.bgr - shading_.colour(Shading::terms_of(point.normal))).norm());
    sorted_ = apart_;
    const auto middle = sorted_.begin() + static_cast<ptrdiff_t>(sorted_.size() / 2);
    std::nth_element(sorted_.begin(), middle, sorted_.end());
    other_paint_ = std::max(kLeast, kMedians * *middle);
    if (*std::ranges::max_element(apart_) <= other_paint_) break;
    shading_.clear();
    for (size_t i = 0; i < surface.size(); ++i) {
      if (apart_[i] <= other_paint_) shading_.add(surface[i].normal, surface[i].bgr);
    }
    shading_.solve();
  }
}

bool SurfaceShading::painted(const EdgeProfile& profile, const ContourEdgel& edgel, double radius_px,
                             double noise) const {
  if (!shading_.known()) return false;
  constexpr double kSigmas = 3;
  for (int k = edgel.half + 1; k <= edgel.half + EdgeModel::kSide; ++k) {
    const Eigen::Vector3d expected =
        shading_.colour(Shading::terms_of(surface_normal(profile, edgel.edge, radius_px, -k)));
    if ((profile.at(-k) - expected).norm() > other_paint_ + kSigmas * noise) return true;
  }
  return false;
}

}  // namespace multireach::vision
