#include "tools/calibrate/camera_file_texts.hpp"

#include <fmt/format.h>

#include <opencv2/calib3d.hpp>

namespace multireach {
namespace {

using Rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// The shortest decimal numbers that convert back to the same values.
template <class Values>
std::string list(const Values& values) {
  return fmt::format("[{}]", fmt::join(values, ", "));
}

std::string list(const double* values, int count) {
  return list(std::vector<double>(values, values + count));
}

int coefficients(const CameraModel& camera) {
  int count = 8;
  while (count > 0 && camera.distortion[static_cast<size_t>(count - 1)] == 0) --count;
  return count <= 4 ? 4 : count <= 5 ? 5 : 8;
}

cv::Matx33d intrinsics(const CameraModel& camera) {
  return {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
}

struct Rectification {
  cv::Matx33d R1, R2;
  cv::Matx34d P1, P2;
  cv::Matx44d Q;
};

Rectification rectification(const StereoRig& rig) {
  const Rotation R = rig.X_RL.linear();
  const Eigen::Vector3d t = rig.X_RL.translation();
  Rectification out;
  cv::stereoRectify(intrinsics(rig.left), rig.left.distortion, intrinsics(rig.right), rig.right.distortion,
                    cv::Size(rig.left.width, rig.left.height), cv::Matx33d(R.data()), cv::Vec3d(t.data()), out.R1,
                    out.R2, out.P1, out.P2, out.Q, cv::CALIB_ZERO_DISPARITY, 0);
  return out;
}

std::string opencv_matrix(const std::string& name, int rows, int columns, const double* data) {
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: {}\n", name, rows, columns,
                     list(data, rows * columns));
}

std::string opencv_text(const StereoRig& rig) {
  const Rectification rectified = rectification(rig);
  const Rotation R = rig.X_RL.linear();
  const Eigen::Vector3d t = rig.X_RL.translation();
  std::string text =
      fmt::format("%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\nunit: m\n", rig.left.width, rig.left.height);
  text += opencv_matrix("M1", 3, 3, intrinsics(rig.left).val);
  text += opencv_matrix("D1", 1, std::max(5, coefficients(rig.left)), rig.left.distortion.data());
  text += opencv_matrix("M2", 3, 3, intrinsics(rig.right).val);
  text += opencv_matrix("D2", 1, std::max(5, coefficients(rig.right)), rig.right.distortion.data());
  text += opencv_matrix("R", 3, 3, R.data());
  text += opencv_matrix("T", 3, 1, t.data());
  text += opencv_matrix("R1", 3, 3, rectified.R1.val);
  text += opencv_matrix("R2", 3, 3, rectified.R2.val);
  text += opencv_matrix("P1", 3, 4, rectified.P1.val);
  text += opencv_matrix("P2", 3, 4, rectified.P2.val);
  return text + opencv_matrix("Q", 4, 4, rectified.Q.val);
}

std::string ros_matrix(const std::string& name, int rows, int columns, const double* data) {
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: {}\n", name, rows, columns, list(data, rows * columns));
}

std::string ros_text(const CameraModel& camera, const char* name, const cv::Matx33d& R, const cv::Matx34d& P) {
  const int count = std::max(5, coefficients(camera));
  return fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", camera.width, camera.height, name) +
         ros_matrix("camera_matrix", 3, 3, intrinsics(camera).val) +
         fmt::format("distortion_model: {}\n", count > 5 ? "rational_polynomial" : "plumb_bob") +
         ros_matrix("distortion_coefficients", 1, count, camera.distortion.data()) +
         ros_matrix("rectification_matrix", 3, 3, R.val) + ros_matrix("projection_matrix", 3, 4, P.val);
}

std::string kalibr_camera(const CameraModel& camera) {
  if (coefficients(camera) > 4) {
    throw InputError(
        "Kalibr's radtan has k1, k2, p1 and p2 only, and this lens has more; calibrate with --lens radtan, or choose "
        "another format");
  }
  return fmt::format(
      "  camera_model: pinhole\n  intrinsics: {}\n  distortion_model: radtan\n  distortion_coeffs: {}\n  resolution: "
      "[{}, "
      "{}]\n",
      list(std::vector{camera.fx, camera.fy, camera.cx, camera.cy}), list(camera.distortion.data(), 4), camera.width,
      camera.height);
}

std::string kalibr_text(const StereoRig& rig) {
  std::string text = "cam0:\n" + kalibr_camera(rig.left) + "cam1:\n" + kalibr_camera(rig.right) + "  T_cn_cnm1:\n";
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T = rig.X_RL.matrix();
  for (int row = 0; row < 4; ++row) text += "  - " + list(T.row(row).data(), 4) + "\n";
  return text;
}

std::string vision_camera(const char* name, const CameraModel& camera) {
  return fmt::format(
      "  {}:\n    width_px: {}\n    height_px: {}\n    fx_px: {}\n    fy_px: {}\n    cx_px: {}\n    cy_px: {}\n"
      "    distortion: {}   # k1 k2 p1 p2 [k3 k4 k5 k6]\n",
      name, camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy,
      list(camera.distortion.data(), coefficients(camera)));
}

/// The errors of the calibration, of few digits: they are estimates.
std::string errors_text(const RigErrors& errors) {
  const Eigen::Matrix<double, RigErrors::kCount, 1> sigma = errors.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  std::string text = fmt::format(
      "  errors:   # standard deviations\n    focal_length_relative: {:.4g}\n    baseline_relative: {:.4g}\n"
      "    rotation_rad: [{:.4g}, {:.4g}, {:.4g}]   # of the right camera, about its axes\n"
      "    correlation:   # of these five\n",
      sigma[RigErrors::kFocalLength], sigma[RigErrors::kBaseline], sigma[RigErrors::kRotationX],
      sigma[RigErrors::kRotationY], sigma[RigErrors::kRotationZ]);
  for (int row = 0; row < RigErrors::kCount; ++row) {
    std::vector<std::string> numbers;
    for (int column = 0; column < RigErrors::kCount; ++column) {
      const double scale = sigma[row] * sigma[column];
      const double correlation = scale > 0 ? errors.covariance(row, column) / scale : 0;
      numbers.push_back(row == column ? "1" : fmt::format("{:.6f}", correlation));
    }
    text += "    - " + list(numbers) + "\n";
  }
  return text;
}

std::string vision_text(const StereoRig& rig, bool robot) {
  std::string text = "cameras:\n" + vision_camera("left", rig.left) + vision_camera("right", rig.right) +
                     "  left_to_right:   # X_RL: a point in the left camera's frame to the right camera's\n" +
                     transform_text(rig.X_RL, "    ");
  if (rig.left.gamma) text += fmt::format("  gamma: {}\n", *rig.left.gamma);
  if (rig.errors.known()) text += errors_text(rig.errors);
  if (robot) {
    text += "  left_to_robot:   # X_WL: a point in the left camera's frame to the robot's base\n" +
            transform_text(rig.X_WL, "    ");
  }
  return text;
}

}  // namespace

std::string transform_text(const Eigen::Isometry3d& X, const std::string& indent) {
  const Rotation R = X.linear();
  const Eigen::Vector3d t = X.translation();
  return indent + "translation_m: " + list(t.data(), 3) + "\n" + indent + "rotation: " + list(R.data(), 9) +
         "   # row by row\n";
}

std::vector<std::string> camera_file_texts(const StereoRig& rig, CameraFormat format, bool robot) {
  switch (format) {
    case CameraFormat::kVision:
      return {vision_text(rig, robot)};
    case CameraFormat::kOpenCv:
      return {opencv_text(rig)};
    case CameraFormat::kKalibr:
      return {kalibr_text(rig)};
    case CameraFormat::kRos: {
      const Rectification rectified = rectification(rig);
      return {ros_text(rig.left, "left", rectified.R1, rectified.P1),
              ros_text(rig.right, "right", rectified.R2, rectified.P2)};
    }
  }
  return {};
}

}  // namespace multireach
