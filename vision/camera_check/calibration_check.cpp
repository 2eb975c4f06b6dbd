#include "vision/camera_check/calibration_check.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::vision {
namespace {

constexpr int kEnough = 100;  // matches
constexpr int kMemory = 300;  // matches, time constant
constexpr double kSigmas = 3;
// An error of the cameras' rotation that shifts the rows by this much, about the axis along the baseline, shifts the
// columns as much about the vertical axis: at 0.5 m, 4 mm along the line of sight of cameras 6 cm apart with a focal
// length of 500 pixels.
constexpr double kLeastRows = 0.5;   // pixels
constexpr double kLeastSize = 0.02;  // half of the share from which on a match is refused

}  // namespace

void CalibrationCheck::Mean::take(double new_value, double new_variance) {
  count = std::min(count + 1, kMemory);
  value += (new_value - value) / count;
  variance += (new_variance - variance) / count;
}

bool CalibrationCheck::Mean::exceeds(double least) const {
  return count >= kEnough && std::abs(value) > std::max(least, kSigmas * std::sqrt(variance));
}

void CalibrationCheck::update(const StereoMatch& match) {
  if (match.status != StereoMatch::Status::kSeen || !match.both_by_contour) return;
  rows_.take(match.epipolar_px, match.epipolar_sigma_px * match.epipolar_sigma_px);
  if (match.size_sigma > 0) size_.take(match.size_share, match.size_sigma * match.size_sigma);
}

CalibrationCheck::Disagreement CalibrationCheck::disagreement() const {
  Disagreement off;
  if (rows_.exceeds(kLeastRows)) off.rows_px = rows_.value;
  if (size_.exceeds(kLeastSize)) off.size_share = size_.value;
  return off;
}

}  // namespace multireach::vision
