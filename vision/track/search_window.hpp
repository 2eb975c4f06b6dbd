#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "imaging/camera_model.hpp"

namespace multireach::vision {

/// How much of an image is searched around a predicted position.
struct WindowSize {
  double nearer_m = 0;   ///< by how much a part of the object may be nearer to the camera than its position
  double around_m = 0;   ///< half the width of what is searched around the predicted position
  double margin_px = 0;  ///< added on each side
  double least_z_m = 0;  ///< least distance of the nearest part from the camera, along its axis
};

/// The square part of an image that shows an object at a predicted position `p_C` (m, in the camera's frame) with this
/// covariance (m^2), within 2.5 standard deviations. It may reach beyond the image. Nothing where a part of the object
/// may be too near, or the window is so large or so far outside that no integer represents it.
std::optional<cv::Rect> search_window(const CameraModel& camera, const Eigen::Vector3d& p_C,
                                      const Eigen::Matrix3d& covariance, const WindowSize& size);

}  // namespace multireach::vision
