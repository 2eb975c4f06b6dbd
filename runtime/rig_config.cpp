#include "runtime/rig_config.hpp"

#include <algorithm>
#include <filesystem>

#include "numeric/trigonometry.hpp"
#include "runtime/camera_files.hpp"

namespace multireach {

CameraModel camera_model_from(const Config& config) {
  CameraModel camera;
  camera.width = static_cast<int>(config.integer("width_px", 2, 16384));
  camera.height = static_cast<int>(config.integer("height_px", 2, 16384));
  camera.fx = config.number("fx_px", 1, 1e6);
  camera.fy = config.number("fy_px", 1, 1e6);
  camera.cx = config.number("cx_px", -1e6, 1e6);
  camera.cy = config.number("cy_px", -1e6, 1e6);
  const std::vector<double> distortion = config.numbers("distortion", -1, std::vector<double>{});
  if (distortion.size() > camera.distortion.size())
    config.fail("distortion", "at most 8 numbers: k1, k2, p1, p2, k3, k4, k5, k6");
  std::copy(distortion.begin(), distortion.end(), camera.distortion.begin());
  config.finish();
  return camera;
}

Eigen::Isometry3d transform_from(const Config& config) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Map<const Eigen::Vector3d>(config.numbers("translation_m", 3).data());
  if (config.has("rotation")) {
    if (config.has("rpy_rad")) config.fail("rpy_rad", "either 'rotation' or 'rpy_rad', not both");
    const std::vector<double> values = config.numbers("rotation", 9);
    X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
    const bool rotation = (X.linear() * X.linear().transpose()).isIdentity(1e-6) && X.linear().determinant() > 0;
    if (!rotation) config.fail("rotation", "a rotation matrix, row by row");
  } else {
    const std::vector<double> rpy = config.numbers("rpy_rad", 3, std::vector<double>{0, 0, 0});
    X.linear() = rotation_from_rpy({rpy[0], rpy[1], rpy[2]});
  }
  config.finish();
  return X;
}

StereoRig inline_rig(const Config& cameras) {
  StereoRig rig;
  rig.left = camera_model_from(cameras.section("left"));
  rig.right = camera_model_from(cameras.section("right"));
  rig.X_RL = transform_from(cameras.section("left_to_right"));
  rig.X_WL.setIdentity();
  return rig;
}

namespace {

Eigen::Isometry3d left_to_robot_from(const Config& section, std::string& files) {
  if (!section.has("file")) return transform_from(section);
  const std::string path = beside(section.file(), section.text("file"));
  section.finish();
  const std::string text = read_text_file(path);
  files += text;
  const Config file = Config::parse(path, text);
  const Eigen::Isometry3d X = transform_from(file.section("left_to_robot"));
  file.finish();
  return X;
}

}  // namespace

RigConfig load_rig(const Config& cameras) {
  RigConfig config;
  StereoRig& rig = config.rig;
  const bool several = cameras.has("files");
  bool knows_robot = false;
  if (several || cameras.has("file")) {
    if (several && cameras.has("file")) cameras.fail("files", "either 'file' or 'files', not both");
    std::vector<std::string> paths = several ? cameras.texts("files") : std::vector<std::string>{cameras.text("file")};
    if (paths.empty() || paths.size() > 2) cameras.fail("files", "one or two names of files");
    CameraFileHints hints;
    if (cameras.has("width_px")) hints.width = static_cast<int>(cameras.integer("width_px", 2, 16384));
    if (cameras.has("height_px")) hints.height = static_cast<int>(cameras.integer("height_px", 2, 16384));
    if (cameras.has("unit")) hints.unit_m = metres_in("unit", cameras.choice("unit", {"m", "cm", "mm", "inch"}));
    for (std::string& path : paths) {
      path = beside(cameras.file(), path);
      std::error_code error;
      if (std::filesystem::equivalent(path, cameras.file(), error)) cameras.fail("file", "another file than this one");
      config.files += read_text_file(path);
    }
    const CameraFiles found = read_camera_files(paths, hints);
    rig = found.rig;
    knows_robot = found.knows_robot;
  } else {
    rig = inline_rig(cameras);
  }
  if (!knows_robot || cameras.has("left_to_robot"))
    rig.X_WL = left_to_robot_from(cameras.section("left_to_robot"), config.files);
  cameras.finish();
  check_rig(rig, cameras.file());
  return config;
}

}  // namespace multireach
