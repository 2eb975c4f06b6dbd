#include "vision/track/unoccluded_size.hpp"

#include <algorithm>

namespace multireach::vision {
namespace {

// What looks larger for a moment is blurred, or seen with something else. What looks smaller for long has turned.
constexpr double kGrow_s = 0.5, kShrink_s = 30;  // time constants: choices

/// Covariance, m^2, of the distance between the centres of two shapes with these radii, the smaller one at one end of
/// the larger one.
Eigen::Matrix3d covariance_of_rest(double smaller_m, double larger_m) {
  const double share = smaller_m / larger_m, sigma_m = (1 - share * share) * larger_m;
  return sigma_m * sigma_m * Eigen::Matrix3d::Identity();
}

// What turns changes its size little from pair to pair. Of noise, the radius of the smallest blobs has a tenth.
constexpr double kSudden = 1.2;
constexpr int64_t kSettles = 10000000;  // us: a choice

}  // namespace

/// The size of the whole object, as far as it is remembered when it is seen with a radius.
double UnoccludedSize::updated(double radius_m, int64_t utime) const {
  if (radius_m_ <= 0) return radius_m;
  const double elapsed_s = 1e-6 * static_cast<double>(utime - utime_);
  const double time_s = radius_m > radius_m_ ? kGrow_s : kShrink_s;
  return radius_m_ + (radius_m - radius_m_) * std::clamp(elapsed_s / time_s, 0.0, 1.0);
}

void UnoccludedSize::update(double radius_m, int64_t utime) {
  if (is_suddenly_larger(radius_m, utime)) return;
  radius_m_ = updated(radius_m, utime);
  utime_ = utime;
}

Eigen::Matrix3d UnoccludedSize::occlusion_covariance(double radius_m, int64_t utime) const {
  const double whole_m = updated(radius_m, utime);
  return radius_m < whole_m ? covariance_of_rest(radius_m, whole_m) : Eigen::Matrix3d::Zero();
}

bool UnoccludedSize::is_suddenly_larger(double radius_m, int64_t utime) const {
  return radius_m_ > 0 && radius_m > kSudden * radius_m_ && utime - utime_ < kSettles;
}

Eigen::Matrix3d UnoccludedSize::surplus_covariance(double radius_m) const {
  return radius_m_ > 0 && radius_m > radius_m_ ? covariance_of_rest(radius_m_, radius_m) : Eigen::Matrix3d::Zero();
}

}  // namespace multireach::vision
