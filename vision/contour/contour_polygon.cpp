#include "vision/contour/contour_polygon.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "imaging/lens.hpp"
#include "numeric/trigonometry.hpp"

namespace multireach::vision {

std::optional<ContourPolygon> polygon_of(const ContourCone& cone, const CameraModel& camera, double scale) {
  const Eigen::Vector3d c = cone.n.normalized();
  const double sine = cone.sine() * scale, cosine = std::sqrt(1 - sine * sine);
  const Eigen::Vector3d u = Eigen::Vector3d::UnitX().cross(c).normalized(), v = c.cross(u);
  double turn_sine, turn_cosine;
  sine_and_cosine_of(2 * std::numbers::pi / kContourCorners, turn_sine, turn_cosine);
  ContourPolygon polygon;
  double s = 0, co = 1;
  for (Eigen::Vector2d& corner : polygon) {
    const Eigen::Vector3d e = cosine * c + sine * (co * u + s * v);
    if (e.z() < 0.05) return std::nullopt;
    corner = image_of(camera, e.hnormalized()).pixel;
    const double next = co * turn_cosine - s * turn_sine;
    s = s * turn_cosine + co * turn_sine;
    co = next;
  }
  return polygon;
}

void cross_rows(const ContourPolygon& polygon, int row, double& from, double& to) {
  from = 1e9;
  to = -1e9;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector2d &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    if ((a.y() <= row) == (b.y() <= row)) continue;
    const double x = a.x() + (row - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    from = std::min(from, x);
    to = std::max(to, x);
  }
}

double half_length(const ContourPolygon& polygon) {
  double longest = 0;
  for (size_t k = 0; k < polygon.size() / 2; ++k)
    longest = std::max(longest, (polygon[k] - polygon[k + polygon.size() / 2]).norm());
  return 0.5 * longest;
}

double half_length(const Blob& blob) {
  const double middle = 0.5 * blob.spread.trace(), apart = 0.5 * (blob.spread(0, 0) - blob.spread(1, 1));
  return 2 * std::sqrt(middle + Eigen::Vector2d(apart, blob.spread(0, 1)).norm());
}

}  // namespace multireach::vision
