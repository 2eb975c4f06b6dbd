#include "robot_bridge/drivers/franka_limits.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace multireach::drivers {
namespace {

/// The speed at a distance d from the end of the range: min(most, sqrt(slope d) - offset), not below 0.
struct VelocityCurve {
  double most;          // rad/s
  double offset;        // rad/s
  double slope;         // rad/s^2
  double lower, upper;  // ends of the range, rad: some mrad beyond the position limits
};

constexpr std::array<VelocityCurve, 7> kResearch3{{{2.62, 0.30, 12, -2.7501, 2.7501},
                                                   {2.62, 0.20, 5.17, -1.7918, 1.7918},
                                                   {2.62, 0.20, 7, -2.9065, 2.9065},
                                                   {2.62, 0.30, 8, -3.0481, -0.1458},
                                                   {5.26, 0.35, 34, -2.8101, 2.8101},
                                                   {4.18, 0.35, 11, 0.54092, 4.5205},
                                                   {5.26, 0.35, 34, -3.0196, 3.0196}}};

}  // namespace

FrankaLimits franka_limits(FrankaModel model) {
  if (model == FrankaModel::kResearch3) return {JointVector::Constant(7, 10), JointVector::Constant(7, 5000)};
  return {(JointVector(7) << 15, 7.5, 10, 12.5, 15, 20, 20).finished(),
          (JointVector(7) << 7500, 3750, 5000, 6250, 7500, 10000, 10000).finished()};
}

JointVector research3_velocity(const JointVector& q, bool upwards) {
  JointVector velocity(7);
  for (int i = 0; i < 7; ++i) {
    const VelocityCurve& curve = kResearch3[static_cast<size_t>(i)];
    const double distance = upwards ? curve.upper - q[i] : q[i] - curve.lower;
    velocity[i] = std::clamp(std::sqrt(curve.slope * std::max(distance, 0.0)) - curve.offset, 0.0, curve.most);
  }
  return velocity;
}

}  // namespace multireach::drivers
