#include "controller/collision/link_at.hpp"

#include <algorithm>

#include "kinematics/joint_frames.hpp"

namespace multireach::controller {

std::optional<int> link_at(const Chain& chain, const Body& body, const JointVector& theta, const Eigen::Vector3d& p) {
  constexpr double kNearTool = 3;  // link radii: a target that the tool reaches for may be there
  if (!(body.link_radius_m > 0) || theta.size() != chain.size()) return std::nullopt;
  std::optional<int> found;
  double nearest = body.link_radius_m;
  const Eigen::Isometry3d X_WT = visit_joints(
      chain, theta, [&](int i, const Eigen::Vector3d&, const Eigen::Vector3d&, const Eigen::Isometry3d& X_WL) {
        const Eigen::Vector3d from = X_WL.translation(), along = X_WL.linear() * chain.fixed(i + 1).translation();
        const double length2 = along.squaredNorm();
        if (!(length2 > 1e-12)) return;
        const double at = std::clamp((p - from).dot(along) / length2, 0.0, 1.0);
        const double apart = (p - from - at * along).norm();
        if (!(apart < nearest)) return;
        nearest = apart;
        found = i;
      });
  if ((p - X_WT.translation()).norm() <= kNearTool * body.link_radius_m) return std::nullopt;
  return found;
}

}  // namespace multireach::controller
