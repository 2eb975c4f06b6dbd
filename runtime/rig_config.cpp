#include "runtime/rig_config.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "numeric/trigonometry.hpp"
#include "runtime/camera_files.hpp"
#include "runtime/config_keys.hpp"

namespace multireach {

namespace {

constexpr double kMostGamma = 5;
constexpr double kFarthest_m = 100;  // of the cameras from the other frame

ConfigKeys<CameraModel> camera_keys() {
  const auto pixels = [](ConfigKeys<CameraModel>& keys, const char* name, double min, auto member,
                         const char* meaning) { keys.number(name, "pixels", min, 1e6, member, meaning).required(); };
  ConfigKeys<CameraModel> keys("vision.yaml, sections cameras.left and cameras.right",
                               "A camera, with the lens model of OpenCV. The centre of the first pixel is (0, 0).");
  keys.integer(
          "width_px", "pixels", 2, 16384, [](auto& c) -> auto& { return c.width; }, "Width of an image.")
      .required();
  keys.integer(
          "height_px", "pixels", 2, 16384, [](auto& c) -> auto& { return c.height; }, "Height of an image.")
      .required();
  pixels(
      keys, "fx_px", 1, [](auto& c) -> auto& { return c.fx; }, "Focal length, horizontal.");
  pixels(
      keys, "fy_px", 1, [](auto& c) -> auto& { return c.fy; }, "Focal length, vertical.");
  pixels(
      keys, "cx_px", -1e6, [](auto& c) -> auto& { return c.cx; }, "Principal point, horizontal.");
  pixels(
      keys, "cy_px", -1e6, [](auto& c) -> auto& { return c.cy; }, "Principal point, vertical.");
  keys.other("distortion", "list of up to 8 numbers", "", "zeros", "k1, k2, p1, p2, k3, k4, k5, k6.",
             [](const Config& config, CameraModel& camera) {
               const std::vector<double> values = config.numbers("distortion", -1, std::vector<double>{});
               if (values.size() > camera.distortion.size())
                 config.fail("distortion", "at most 8 numbers: k1, k2, p1, p2, k3, k4, k5, k6");
               if (!are_usable(values)) config.fail("distortion", kUsableDistortion);
               std::copy(values.begin(), values.end(), camera.distortion.begin());
             });
  return keys;
}

Eigen::Vector3d vector3_from(const Config& config, const std::string& key) {
  return Eigen::Map<const Eigen::Vector3d>(config.numbers(key, 3).data());
}

/// A camera at `eye` whose optical axis (z) points at `at`; y points down as far as it can.
Eigen::Isometry3d pose_looking_at(const Config& config) {
  const Eigen::Vector3d eye = vector3_from(config, "from_m"), at = vector3_from(config, "at_m");
  const Eigen::Vector3d up = config.has("up") ? vector3_from(config, "up") : Eigen::Vector3d::UnitZ();
  config.finish();
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = eye;
  if (!((at - eye).norm() > 1e-6)) config.fail("at_m", "another point than from_m");
  const Eigen::Vector3d z = (at - eye).normalized();
  const Eigen::Vector3d right = z.cross(up);
  if (eye.norm() > kFarthest_m) config.fail("from_m", "at most 100 m: metres, not mm");
  if (!(right.norm() > 1e-6 * up.norm())) config.fail("up", "a direction that is not along the line of sight");
  const Eigen::Vector3d x = right.normalized();
  X.linear() << x, z.cross(x), z;
  return X;
}

struct Transform {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  int rotations = 0;  // keys that gave the rotation
};

void read_rotation(const Config& config, Transform& transform) {
  if (!config.has("rotation")) return;
  ++transform.rotations;
  const std::vector<double> values = config.numbers("rotation", 9);
  transform.X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
  const Eigen::Matrix3d R = transform.X.linear();
  if (!((R * R.transpose()).isIdentity(1e-6) && R.determinant() > 0))
    config.fail("rotation", "a rotation matrix, row by row");
}

void read_translation(const Config& config, Transform& transform) {
  transform.X.translation() = vector3_from(config, "translation_m");
  if (transform.X.translation().norm() > kFarthest_m) config.fail("translation_m", "at most 100 m: metres, not mm");
}

void read_rpy(const Config& config, Transform& transform) {
  if (!config.has("rpy_rad")) return;
  if (transform.rotations++ > 0) config.fail("rpy_rad", "either 'rotation' or 'rpy_rad', not both");
  const std::vector<double> rpy = config.numbers("rpy_rad", 3);
  if (std::ranges::any_of(rpy, [](double angle) { return std::abs(angle) > 2 * std::numbers::pi; }))
    config.fail("rpy_rad", "angles from -2 pi to 2 pi: radians, not degrees");
  transform.X.linear() = rotation_from_rpy({rpy[0], rpy[1], rpy[2]});
}

ConfigKeys<Transform> transform_keys() {
  return ConfigKeys<Transform>(
             "vision.yaml, sections cameras.left_to_right and cameras.left_to_robot",
             "A rigid transform: of points in the left camera's frame to the right camera's (OpenCV's R and "
             "T), or to W. A camera's frame has x to the right, y down and z forward.")
      .other("look_at", "map with `from_m`, `at_m`, `up`", "m", "none",
             "Only `left_to_robot`, instead of all other keys: the camera is at `from_m` and looks at the point "
             "`at_m`, both in W; "
             "`up` (default 0, 0, 1) points up in the image.",
             [](const Config&, Transform&) {})
      .other("file", "text", "", "none",
             "Only `left_to_robot`, instead of all other keys: the file that `multireach-calibrate hand-eye` wrote.",
             [](const Config&, Transform&) {})
      .other("translation_m", "list of 3 numbers", "m", "required", "Position of the left camera in the other frame.",
             read_translation)
      .other("rotation", "list of 9 numbers", "", "none", "The rotation matrix, row by row.", read_rotation)
      .other("rpy_rad", "list of 3 numbers", "rad", "0, 0, 0",
             "Instead of `rotation`: roll, pitch and yaw about the fixed axes x, y, z in this order, as in URDF: R = "
             "Rz(yaw) Ry(pitch) Rx(roll).",
             read_rpy);
}

/// Standard deviations of a calibration's errors, in the order of RigErrors, and their correlation.
struct ErrorsSection {
  Eigen::Matrix<double, RigErrors::kCount, 1> sigma = Eigen::Matrix<double, RigErrors::kCount, 1>::Zero();
  Eigen::Matrix<double, RigErrors::kCount, RigErrors::kCount> correlation =
      Eigen::Matrix<double, RigErrors::kCount, RigErrors::kCount>::Identity();
};

void read_rotation_sigmas(const Config& config, ErrorsSection& section) {
  if (!config.has("rotation_rad")) return;
  section.sigma.tail<3>() = vector3_from(config, "rotation_rad");
  if (!(section.sigma.minCoeff() >= 0 && section.sigma.maxCoeff() <= 0.1))
    config.fail("rotation_rad", "three standard deviations from 0 to 0.1 rad");
}

void read_correlation(const Config& config, ErrorsSection& section) {
  if (!config.has("correlation")) return;
  constexpr int kCount = RigErrors::kCount;
  const std::vector<double> values = config.matrix("correlation", kCount, kCount);
  section.correlation = Eigen::Map<const Eigen::Matrix<double, kCount, kCount, Eigen::RowMajor>>(values.data());
  constexpr double kRounding = 1e-4;  // of numbers that were written with a few digits
  const auto& C = section.correlation;
  const bool symmetric = (C - C.transpose()).cwiseAbs().maxCoeff() < kRounding;
  const bool ones = (C.diagonal().array() - 1).abs().maxCoeff() < kRounding;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kCount, kCount>> axes(0.5 * (C + C.transpose()));
  if (!(symmetric && ones && axes.eigenvalues().minCoeff() > -kRounding))
    config.fail("correlation", "a correlation matrix: symmetric, with ones on its diagonal, positive semidefinite");
  // Rounding may have made an eigenvalue negative.
  section.correlation =
      axes.eigenvectors() * axes.eigenvalues().cwiseMax(0).asDiagonal() * axes.eigenvectors().transpose();
}

ConfigKeys<ErrorsSection> errors_keys() {
  constexpr double kMax = 0.1;
  return ConfigKeys<ErrorsSection>(
             "vision.yaml, section cameras.errors",
             "Standard deviations of the calibration's errors, as `multireach-calibrate cameras` writes them. The "
             "covariance of every reported position includes what they cause.")
      .number(
          "focal_length_relative", "", 0, kMax, [](auto& s) -> auto& { return s.sigma[RigErrors::kFocalLength]; },
          "Of the focal lengths of both cameras together, relative.")
      .number(
          "baseline_relative", "", 0, kMax, [](auto& s) -> auto& { return s.sigma[RigErrors::kBaseline]; },
          "Of the distance between the cameras, relative.")
      .other("rotation_rad", "list of 3 numbers from 0 to 0.1", "rad", "0, 0, 0",
             "Of the right camera's orientation relative to the left camera, about the right camera's axes x, y, z.",
             read_rotation_sigmas)
      .other("correlation", "5 lists of 5 numbers", "", "none",
             "Correlation matrix of these five, in this order. Without it they are independent.", read_correlation);
}

}  // namespace

RigErrors rig_errors_from(const Config& config) {
  ErrorsSection section;
  errors_keys().read(config, section);
  RigErrors errors;
  errors.covariance = section.sigma.asDiagonal() * section.correlation * section.sigma.asDiagonal();
  return errors;
}

CameraModel camera_model_from(const Config& config) {
  CameraModel camera;
  camera_keys().read(config, camera);
  return camera;
}

Eigen::Isometry3d transform_from(const Config& config) {
  Transform transform;
  transform_keys().read(config, transform);
  return transform.X;
}

StereoRig inline_rig(const Config& cameras) {
  StereoRig rig;
  rig.left = camera_model_from(cameras.section("left"));
  rig.right = camera_model_from(cameras.section("right"));
  rig.X_RL = transform_from(cameras.section("left_to_right"));
  rig.X_WL.setIdentity();
  if (cameras.has("gamma")) rig.left.gamma = rig.right.gamma = cameras.number("gamma", 1, kMostGamma);
  if (cameras.has("errors")) rig.errors = rig_errors_from(cameras.section("errors"));
  return rig;
}

namespace {

Eigen::Isometry3d left_to_robot_from(const Config& section, std::string& files) {
  if (section.has("look_at")) {
    const Eigen::Isometry3d X = pose_looking_at(section.section("look_at"));
    section.finish();
    return X;
  }
  if (!section.has("file")) return transform_from(section);
  const std::string path = resolve_relative(section.file(), section.text("file"));
  section.finish();
  const std::string text = read_text_file(path);
  files += text;
  const Config file = Config::parse(path, text);
  const Eigen::Isometry3d X = transform_from(file.section("left_to_robot"));
  file.finish();
  return X;
}

/// What the section `cameras` says.
struct CamerasSection {
  std::vector<std::string> paths;
  CameraFileHints hints;
  std::optional<double> gamma;
};

ConfigKeys<CamerasSection> cameras_keys() {
  using Section = CamerasSection;
  const auto read_elsewhere = [](const char* key) { return [=](const Config& config, Section&) { config.has(key); }; };
  return ConfigKeys<Section>("vision.yaml, section cameras",
                             "The two cameras: `left`, `right` and `left_to_right`, or the files of a calibration.")
      .other("left_to_robot", "section", "", "none",
             "X_WL. Without it (and unless `file` is a vision.yaml that has it), targets are in the left camera's "
             "frame and "
             "of status UNCALIBRATED, for `multireach-calibrate hand-eye`.",
             read_elsewhere("left_to_robot"))
      .other(
          "errors", "section", "", "none",
          "How uncertain the calibration is. Default: as `file` says, if that is a vision.yaml; otherwise not known, "
          "and the covariances of positions do not include it.",
          read_elsewhere("errors"))
      .number(
          "gamma", "", 1, kMostGamma, [](auto& s) -> auto& { return s.gamma; },
          "Of both cameras: grey levels are light to the power of 1 / gamma. 1 for rendered images and most industrial "
          "cameras, about 2.2 for most others. Where the chroma is not subsampled, edges are corrected for it.")
      .otherwise("as `file` says; otherwise not known, and the covariances of positions allow for one of up to 2.2")
      .other("file", "text", "", "none",
             "A calibration in a third-party format: OpenCV, Kalibr, or another vision.yaml.",
             [](const Config& config, Section& s) {
               if (config.has("file")) s.paths = {config.text("file")};
             })
      .other("files", "list of 1 or 2 texts", "", "none",
             "Instead of `file`: the two files of ROS (left, right) or of OpenCV (intrinsics, extrinsics).",
             [](const Config& config, Section& s) {
               if (!config.has("files")) return;
               if (!s.paths.empty()) config.fail("files", "either 'file' or 'files', not both");
               s.paths = config.texts("files");
               if (s.paths.empty() || s.paths.size() > 2) config.fail("files", "one or two names of files");
             })
      .only("without file and files", [](const Section& s) { return s.paths.empty(); })
      .other("left", "section", "", "required", "The left camera.", read_elsewhere("left"))
      .other("right", "section", "", "required", "The right camera.", read_elsewhere("right"))
      .other("left_to_right", "section", "", "required", "X_RL.", read_elsewhere("left_to_right"))
      .only("with file or files", [](const Section& s) { return !s.paths.empty(); })
      .integer(
          "width_px", "pixels", 2, 16384, [](auto& s) -> auto& { return s.hints.width; },
          "Width of the images, where the files do not tell it.")
      .integer(
          "height_px", "pixels", 2, 16384, [](auto& s) -> auto& { return s.hints.height; },
          "Height of the images, where the files do not tell it.")
      .other("unit", "`m`, `cm`, `mm`, `inch`", "", "none", "Unit of the baseline, where the files do not tell it.",
             [](const Config& config, Section& s) {
               if (config.has("unit"))
                 s.hints.unit_m = unit_length_m("unit", config.choice("unit", {"m", "cm", "mm", "inch"}));
             });
}

}  // namespace

std::string rig_config_reference() {
  return cameras_keys().reference() + "\n" + camera_keys().reference() + "\n" + transform_keys().reference() + "\n" +
         errors_keys().reference();
}

RigConfig load_rig(const Config& cameras) {
  RigConfig config;
  StereoRig& rig = config.rig;
  CamerasSection section;
  cameras_keys().read(cameras, section);
  if (section.paths.empty()) {
    rig = inline_rig(cameras);
  } else {
    for (std::string& path : section.paths) {
      path = resolve_relative(cameras.file(), path);
      std::error_code error;
      if (std::filesystem::equivalent(path, cameras.file(), error)) cameras.fail("file", "another file than this one");
      config.files += read_text_file(path);
    }
    const CameraFiles found = read_camera_files(section.paths, section.hints);
    rig = found.rig;
    if (section.gamma) rig.left.gamma = rig.right.gamma = section.gamma;
    if (cameras.has("errors")) rig.errors = rig_errors_from(cameras.section("errors"));
    config.has_robot_pose = found.has_robot_pose;
  }
  if (cameras.has("left_to_robot")) {
    rig.X_WL = left_to_robot_from(cameras.section("left_to_robot"), config.files);
    config.has_robot_pose = true;
  }
  check_rig(rig, cameras.file());
  return config;
}

}  // namespace multireach
