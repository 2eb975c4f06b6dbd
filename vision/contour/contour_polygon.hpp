#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "imaging/camera_model.hpp"
#include "vision/colour/blob.hpp"
#include "vision/contour/contour_cone.hpp"

namespace multireach::vision {

/// Number of corners of a contour polygon.
constexpr int kContourCorners = 64;
using ContourPolygon = std::array<Eigen::Vector2d, kContourCorners>;

/// The cone's image as a polygon, in pixels, with corners at equal angles about its axis. `scale` multiplies the sine
/// of the angular radius. Nothing when a part of the cone is not in front of the camera.
[[nodiscard]] std::optional<ContourPolygon> polygon_of(const ContourCone& cone, const CameraModel& camera,
                                                       double scale = 1);

/// The smallest and the largest column at which a polygon crosses a row; from > to when it does not.
void cross_rows(const ContourPolygon& polygon, int row, double& from, double& to);

/// Half the longest diameter of a contour, pixels.
[[nodiscard]] double half_length(const ContourPolygon& polygon);
/// The same of the ellipse that has the blob's second moments.
[[nodiscard]] double half_length(const Blob& blob);

}  // namespace multireach::vision
