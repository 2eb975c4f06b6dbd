#include "imaging/camera_model.hpp"

#include <opencv2/calib3d.hpp>

namespace multireach {
namespace {

cv::Matx33d intrinsic_matrix(const CameraModel& camera) {
  return {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
}

}  // namespace

Eigen::Vector2d CameraModel::project(const Eigen::Vector3d& p_C) const {
  const std::vector<cv::Point3d> points{{p_C.x(), p_C.y(), p_C.z()}};
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), intrinsic_matrix(*this), distortion, pixels);
  return {pixels[0].x, pixels[0].y};
}

Eigen::Vector2d CameraModel::ray(const Eigen::Vector2d& pixel) const {
  return rays({pixel})[0];
}

std::vector<Eigen::Vector2d> CameraModel::rays(const std::vector<Eigen::Vector2d>& pixels) const {
  if (pixels.empty()) return {};
  std::vector<cv::Point2d> distorted, directions;
  for (const Eigen::Vector2d& pixel : pixels) distorted.emplace_back(pixel.x(), pixel.y());
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-10);
  cv::undistortPoints(distorted, directions, intrinsic_matrix(*this), distortion, cv::noArray(), cv::noArray(), until);
  std::vector<Eigen::Vector2d> result;
  for (const cv::Point2d& direction : directions) result.emplace_back(direction.x, direction.y);
  return result;
}

}  // namespace multireach
