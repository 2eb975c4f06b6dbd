#include "controller/collision/obstacle.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::controller {
namespace {

/// The signed distance of `p` from a ball about `centre`, all in one frame; writes the unit vector `away` from the
/// ball.
double from_ball(const Eigen::Vector3d& p, const Eigen::Vector3d& centre, double radius, Eigen::Vector3d& away) {
  const Eigen::Vector3d r = p - centre;
  const double distance = r.norm();
  away = distance > 1e-12 ? Eigen::Vector3d(r / distance) : Eigen::Vector3d::UnitX();
  return distance - radius;
}

}  // namespace

bool is_valid(const Obstacle& obstacle) {
  const Eigen::Matrix3d R = obstacle.X_WO.linear();
  if (!obstacle.X_WO.matrix().allFinite() || !(obstacle.X_WO.translation().cwiseAbs().maxCoeff() < 1e6)) return false;
  if (!((R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6)) return false;
  const auto fits = [](double size) { return size > 0 && size < 1e3; };
  switch (obstacle.shape) {
    case Obstacle::Shape::kSphere:
      return fits(obstacle.size[0]);
    case Obstacle::Shape::kCapsule:
      return fits(obstacle.size[0]) && obstacle.size[1] >= 0 && obstacle.size[1] < 1e3;
    case Obstacle::Shape::kBox:
      return fits(obstacle.size[0]) && fits(obstacle.size[1]) && fits(obstacle.size[2]);
  }
  return false;
}

double signed_distance(const Obstacle& obstacle, const Eigen::Vector3d& p, Eigen::Vector3d& away) {
  const Eigen::Vector3d q = obstacle.X_WO.inverse(Eigen::Isometry) * p;
  Eigen::Vector3d direction;
  double distance = 0;
  switch (obstacle.shape) {
    case Obstacle::Shape::kSphere:
      distance = from_ball(q, Eigen::Vector3d::Zero(), obstacle.size[0], direction);
      break;
    case Obstacle::Shape::kCapsule: {
      const double half = 0.5 * obstacle.size[1];
      distance = from_ball(q, {0, 0, std::clamp(q.z(), -half, half)}, obstacle.size[0], direction);
      break;
    }
    case Obstacle::Shape::kBox: {
      const Eigen::Vector3d half = 0.5 * obstacle.size;
      const Eigen::Vector3d nearest = q.cwiseMax(-half).cwiseMin(half);
      if (nearest != q) {
        distance = from_ball(q, nearest, 0, direction);
        break;
      }
      int face = 0;
      const Eigen::Vector3d depth = half - q.cwiseAbs();
      depth.minCoeff(&face);
      direction = Eigen::Vector3d::Zero();
      direction[face] = q[face] < 0 ? -1 : 1;
      distance = -depth[face];
      break;
    }
  }
  away = obstacle.X_WO.linear() * direction;
  return distance;
}

}  // namespace multireach::controller
