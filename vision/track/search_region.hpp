#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "imaging/camera_model.hpp"

namespace multireach::vision {

/// Where a target may be: the positions of its centre, a box along the axes of W, in metres. What has its colour
/// elsewhere is not the target.
using SearchRegion = Eigen::AlignedBox3d;

/// The part of a camera's image that shows the region, and around it an object whose centre is inside: a margin of a
/// quarter of that part's size. Empty where the camera does not see the region. X_CW maps W to the camera's frame.
[[nodiscard]] cv::Rect search_area(const SearchRegion& region, const CameraModel& camera,
                                   const Eigen::Isometry3d& X_CW);

/// Whether a measured position can be inside the region: along each axis within three standard deviations.
[[nodiscard]] bool may_be_inside(const SearchRegion& region, const Eigen::Vector3d& p_W,
                                 const Eigen::Matrix3d& covariance);

}  // namespace multireach::vision
