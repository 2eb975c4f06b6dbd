#include "vision/track/unoccluded_size.hpp"

#include <algorithm>

namespace multireach::vision {
namespace {

// What looks larger for a moment is blurred, or seen with something else. What looks smaller for long has turned.
constexpr double kGrow_s = 0.5, kShrink_s = 30;  // time constants: choices

}  // namespace

void UnoccludedSize::update(double radius_m, double elapsed_s) {
  if (radius_m_ <= 0) {
    radius_m_ = radius_m;
    return;
  }
  const double time_s = radius_m > radius_m_ ? kGrow_s : kShrink_s;
  radius_m_ += (radius_m - radius_m_) * std::clamp(elapsed_s / time_s, 0.0, 1.0);
}

Eigen::Matrix3d UnoccludedSize::occlusion_covariance(double radius_m) const {
  if (!(radius_m < radius_m_)) return Eigen::Matrix3d::Zero();
  const double share = radius_m / radius_m_, sigma_m = (1 - share * share) * radius_m_;
  return sigma_m * sigma_m * Eigen::Matrix3d::Identity();
}

}  // namespace multireach::vision
