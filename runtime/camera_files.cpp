#include "runtime/camera_files.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "runtime/config.hpp"
#include "runtime/rig_config.hpp"

namespace multireach {

bool are_usable(std::span<const double> distortion) {
  constexpr double kLargest = 1e9;
  return std::ranges::all_of(distortion, [](double value) { return std::abs(value) <= kLargest; });
}

namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr std::pair<const char*, CameraFormat> kFormats[] = {{"vision", CameraFormat::kVision},
                                                             {"opencv", CameraFormat::kOpenCv},
                                                             {"ros", CameraFormat::kRos},
                                                             {"kalibr", CameraFormat::kKalibr}};
constexpr std::pair<const char*, double> kUnits[] = {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"inch", 0.0254}};

template <class Value, size_t kSize>
Value chosen(const std::pair<const char*, Value> (&table)[kSize], const std::string& option, const std::string& word) {
  std::string known;
  for (const auto& [name, value] : table) {
    if (word == name) return value;
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  throw InputError(option + " is '" + word + "'; expected one of " + known);
}

Config parsed(const std::string& path) {
  std::string text = read_text_file(path);
  // OpenCV's first line, "%YAML:1.0", is not a valid YAML directive.
  if (text.starts_with("%YAML:")) text.erase(0, std::min(text.find('\n'), text.size()));
  return Config::parse(path, text);
}

/// The rotation nearest to a matrix that was rounded to few digits.
Eigen::Matrix3d rotation_of(const std::vector<double>& values, const Config& file, const std::string& key) {
  const Eigen::Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
  constexpr double kRounding = 2e-3;
  if (!(R * R.transpose()).isIdentity(kRounding) || R.determinant() < 0) file.fail(key, "a rotation matrix");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

/// A matrix in the format of OpenCV and ROS: rows, cols, data. `rows` or `columns` 0 accepts any number.
RowMatrix matrix_of(const Config& file, const std::string& key, int rows, int columns) {
  const Config section = file.section(key);
  const auto r = static_cast<int>(section.integer("rows", 1, 100)),
             c = static_cast<int>(section.integer("cols", 1, 100));
  if ((rows > 0 && r != rows) || (columns > 0 && c != columns))
    file.fail(key, fmt::format("a matrix of {} x {}, not of {} x {}", rows, columns, r, c));
  const std::vector<double> data = section.numbers("data", r * c);
  return Eigen::Map<const RowMatrix>(data.data(), r, c);
}

void set_intrinsics(CameraModel& camera, const RowMatrix& K, const Config& file, const std::string& key) {
  camera.fx = K(0, 0);
  camera.fy = K(1, 1);
  camera.cx = K(0, 2);
  camera.cy = K(1, 2);
  if (!(camera.fx > 0 && camera.fy > 0)) file.fail(key, "focal lengths above 0");
  if (K(0, 1) != 0 || K(1, 0) != 0 || K(2, 0) != 0 || K(2, 1) != 0 || K(2, 2) != 1)
    file.fail(key, "[fx, 0, cx, 0, fy, cy, 0, 0, 1]: no skew");
}

void set_distortion(CameraModel& camera, const double* values, Eigen::Index count, const Config& file,
                    const std::string& key) {
  const auto known = static_cast<Eigen::Index>(camera.distortion.size());
  for (Eigen::Index k = known; k < count; ++k) {
    if (values[k] != 0) file.fail(key, "a lens without thin prism and tilt: only zeros after k6");
  }
  const std::span<const double> of_lens(values, static_cast<size_t>(std::min(count, known)));
  if (!are_usable(of_lens)) file.fail(key, kUsableDistortion);
  std::ranges::copy(of_lens, camera.distortion.begin());
}

int size_from(const Config* file, const char* key, const std::optional<int>& hint, const std::string& path) {
  if (file) return static_cast<int>(file->integer(key, 2, 16384));
  if (!hint)
    throw InputError(path + ": does not say the images' size: --size WxH, or width_px and height_px in a vision file");
  return *hint;
}

void read_opencv(const std::vector<Config>& files, const CameraFileHints& hints, CameraFiles& out) {
  const auto with = [&files](const std::string& key) -> const Config& {
    for (const Config& file : files) {
      if (file.has(key)) return file;
    }
    throw InputError(files.front().file() + ": has no '" + key +
                     "'; an OpenCV stereo calibration has M1, D1, M2, D2, R and T, in one file or in two");
  };
  const Config* sized = nullptr;
  for (const Config& file : files) {
    if (file.has("image_width")) sized = &file;
  }
  int side = 0;
  for (CameraModel* camera : {&out.rig.left, &out.rig.right}) {
    const std::string number = std::to_string(++side);
    set_intrinsics(*camera, matrix_of(with("M" + number), "M" + number, 3, 3), with("M" + number), "M" + number);
    const RowMatrix D = matrix_of(with("D" + number), "D" + number, 0, 0);
    set_distortion(*camera, D.data(), D.size(), with("D" + number), "D" + number);
    camera->width = size_from(sized, "image_width", hints.width, files.front().file());
    camera->height = size_from(sized, "image_height", hints.height, files.front().file());
    // The image size may come from the user, so a calibration for another resolution would otherwise go unnoticed.
    const double x = camera->cx / camera->width, y = camera->cy / camera->height;
    if (std::min(x, y) < 0.27 || std::max(x, y) > 0.73) {
      with("M" + number)
          .fail("M" + number, fmt::format("a principal point near the middle of {} x {} pixels, not ({:.0f}, "
                                          "{:.0f}): the calibration is for images of another size",
                                          camera->width, camera->height, camera->cx, camera->cy));
    }
  }
  const RowMatrix R = matrix_of(with("R"), "R", 3, 3), T = matrix_of(with("T"), "T", 0, 0);
  if (T.size() != 3) with("T").fail("T", "three numbers");
  out.rig.X_RL.linear() = rotation_of({R.data(), R.data() + 9}, with("R"), "R");
  out.rig.X_RL.translation() = Eigen::Map<const Eigen::Vector3d>(T.data());
  double unit_m = 0;
  for (const Config& file : files) {
    if (file.has("unit")) unit_m = unit_length_m(file.file() + ": unit", file.text("unit"));
  }
  if (hints.unit_m && unit_m > 0 && *hints.unit_m != unit_m)
    throw InputError(files.front().file() + ": states another unit than the one given");
  if (hints.unit_m) unit_m = *hints.unit_m;
  if (unit_m <= 0) {
    throw InputError(
        files.front().file() +
        ": does not say the unit of T (that of the board's squares); give --unit m|cm|mm|inch, or unit in a vision "
        "file");
  }
  out.rig.X_RL.translation() *= unit_m;
}

/// Reads one camera_info file. Returns the projection matrix, 3 x 4, and the rectifying rotation.
std::pair<RowMatrix, Eigen::Matrix3d> read_camera_info(const Config& file, CameraModel& camera) {
  camera.width = static_cast<int>(file.integer("image_width", 2, 16384));
  camera.height = static_cast<int>(file.integer("image_height", 2, 16384));
  set_intrinsics(camera, matrix_of(file, "camera_matrix", 3, 3), file, "camera_matrix");
  file.choice("distortion_model", {"plumb_bob", "rational_polynomial"});
  const RowMatrix D = matrix_of(file, "distortion_coefficients", 0, 0);
  set_distortion(camera, D.data(), D.size(), file, "distortion_coefficients");
  const RowMatrix R = matrix_of(file, "rectification_matrix", 3, 3);
  return {matrix_of(file, "projection_matrix", 3, 4),
          rotation_of({R.data(), R.data() + 9}, file, "rectification_matrix")};
}

void read_ros(const std::vector<Config>& files, const CameraFileHints& hints, CameraFiles& out) {
  if (files.size() != 2)
    throw InputError(files.front().file() + ": is one camera's camera_info; give two files, left and right");
  const auto [P1, R1] = read_camera_info(files[0], out.rig.left);
  const auto [P2, R2] = read_camera_info(files[1], out.rig.right);
  if (P1(0, 3) != 0) {
    files[0].fail("projection_matrix", P2(0, 3) == 0
                                           ? "P[0,3] = 0 in the left camera's file: left and right are swapped"
                                           : "P[0,3] = 0 in the left camera's file");
  }
  if (!(P2(0, 0) > 0 && P2(1, 1) > 0)) files[1].fail("projection_matrix", "focal lengths above 0");
  if (P2(0, 3) == 0) {
    files[1].fail("projection_matrix",
                  "P[0,3] = -fx B in the right camera's file; it is 0: the cameras were calibrated one by one");
  }
  // The rectified frames are parallel; the last column of P gives the translation between them.
  const Eigen::Vector3d t(P2(0, 3) / P2(0, 0), P2(1, 3) / P2(1, 1), 0);
  out.rig.X_RL.linear() = R2.transpose() * R1;
  out.rig.X_RL.translation() = hints.unit_m.value_or(1) * (R2.transpose() * t);
  out.assumptions.push_back("camera_info has no R and T: taken from the rectification matrices and P[0,3] = " +
                            fmt::format("{:.6g} = -fx B, in {}", P2(0, 3), hints.unit_m ? "the unit given" : "metres"));
  if (R1.isIdentity(0) && R2.isIdentity(0))
    out.assumptions.push_back("both rectification matrices are the identity: the cameras are taken as parallel");
}

void read_kalibr(const Config& file, const CameraFileHints& hints, CameraFiles& out) {
  const auto read = [](const Config& section, CameraModel& camera) {
    section.choice("camera_model", {"pinhole"});
    const std::string lens = section.text("distortion_model");
    if (lens == "equidistant") {
      section.fail(
          "distortion_model",
          "radtan: fisheye lenses are not supported; calibrate again with pinhole-radtan, or undistort the images");
    }
    if (lens != "radtan" && lens != "none") section.fail("distortion_model", "radtan");
    const std::vector<double> intrinsics = section.numbers("intrinsics", 4);
    camera.fx = intrinsics[0];
    camera.fy = intrinsics[1];
    camera.cx = intrinsics[2];
    camera.cy = intrinsics[3];
    constexpr double kMost = 1e6;  // as in vision.yaml
    if (!(camera.fx > 0 && camera.fy > 0 && camera.fx <= kMost && camera.fy <= kMost))
      section.fail("intrinsics", "focal lengths above 0, at most 1e6 pixels");
    if (lens == "radtan") {
      const std::vector<double> distortion = section.numbers("distortion_coeffs", 4);
      if (!are_usable(distortion)) section.fail("distortion_coeffs", kUsableDistortion);
      std::copy(distortion.begin(), distortion.end(), camera.distortion.begin());
    }
    const std::vector<double> size = section.numbers("resolution", 2);
    if (std::ranges::any_of(
            size, [](double pixels) { return !(pixels >= 2 && pixels <= 16384 && pixels == std::floor(pixels)); }))
      section.fail("resolution", "[width, height] in whole pixels, 2 to 16384");
    camera.width = static_cast<int>(size[0]);
    camera.height = static_cast<int>(size[1]);
  };
  const Config left = file.section("cam0"), right = file.section("cam1");
  read(left, out.rig.left);
  read(right, out.rig.right);
  const std::vector<double> T = right.matrix("T_cn_cnm1", 4, 4);
  out.rig.X_RL.linear() = rotation_of({T[0], T[1], T[2], T[4], T[5], T[6], T[8], T[9], T[10]}, right, "T_cn_cnm1");
  if (T[12] != 0 || T[13] != 0 || T[14] != 0 || T[15] != 1) right.fail("T_cn_cnm1", "a last row of 0, 0, 0, 1");
  out.rig.X_RL.translation() = hints.unit_m.value_or(1) * Eigen::Vector3d(T[3], T[7], T[11]);
}

void read_vision(const Config& file, const CameraFileHints& hints, CameraFiles& out) {
  const Config cameras = file.section("cameras");
  if (cameras.has("file") || cameras.has("files"))
    throw InputError(file.file() + ": its cameras are in another file; name that one");
  out.rig = inline_rig(cameras);
  out.has_robot_pose = cameras.has("left_to_robot");
  if (out.has_robot_pose) out.rig.X_WL = transform_from(cameras.section("left_to_robot"));
  cameras.finish();
  out.rig.X_RL.translation() *= hints.unit_m.value_or(1);
}

}  // namespace

CameraFormat camera_format_of(const std::string& option, const std::string& word) {
  return chosen(kFormats, option, word);
}

double unit_length_m(const std::string& option, const std::string& unit) {
  return chosen(kUnits, option, unit);
}

CameraFormat format_from_names(const std::vector<std::string>& paths) {
  if (paths.size() == 2) return CameraFormat::kRos;
  const std::filesystem::path path(paths.front());
  if (path.filename().string().find("camchain") != std::string::npos) return CameraFormat::kKalibr;
  return path.extension() == ".yml" ? CameraFormat::kOpenCv : CameraFormat::kVision;
}

CameraFiles read_camera_files(const std::vector<std::string>& paths, const CameraFileHints& hints) {
  std::vector<Config> files;
  for (const std::string& path : paths) files.push_back(parsed(path));
  const auto any = [&files](const char* key) {
    return std::ranges::any_of(files, [key](const Config& file) { return file.has(key); });
  };
  CameraFiles out;
  out.rig.X_RL.setIdentity();
  out.rig.X_WL.setIdentity();
  if (any("M1") || any("M2")) {
    out.format = CameraFormat::kOpenCv;
    read_opencv(files, hints, out);
  } else if (any("camera_matrix")) {
    out.format = CameraFormat::kRos;
    read_ros(files, hints, out);
  } else if (files.size() > 1) {
    throw InputError(
        paths[0] + ", " + paths[1] +
        ": are neither camera_info of two cameras (camera_matrix ...) nor an OpenCV calibration (M1 D1 M2 D2, R T)");
  } else if (any("cam0") || any("cam1")) {
    out.format = CameraFormat::kKalibr;
    read_kalibr(files.front(), hints, out);
  } else if (any("cameras")) {
    read_vision(files.front(), hints, out);
  } else {
    throw InputError(paths.front() +
                     ": is no calibration of two cameras: neither OpenCV's (M1 D1 M2 D2 R T), nor ROS's camera_info "
                     "(camera_matrix ...), nor Kalibr's camchain (cam0, cam1), nor a vision file (cameras)");
  }
  for (const CameraModel* camera : {&out.rig.left, &out.rig.right}) {
    const int width = hints.width.value_or(camera->width), height = hints.height.value_or(camera->height);
    if (camera->width == width && camera->height == height) continue;
    throw InputError(fmt::format("{}: is for images of {} x {} pixels; the given size is {} x {}", paths.front(),
                                 camera->width, camera->height, width, height));
  }
  check_rig(out.rig, paths.back());
  return out;
}

void check_rig(const StereoRig& rig, const std::string& file) {
  for (const CameraModel* camera : {&rig.left, &rig.right}) {
    if (!(camera->width > 0 && camera->height > 0)) throw InputError(file + ": an image size is not positive");
    if (!(camera->fx > 0 && camera->fy > 0)) throw InputError(file + ": a focal length is not positive");
  }
  const Eigen::Vector3d right_L = rig.X_RL.inverse().translation();
  const double baseline = right_L.norm();
  constexpr double kSmallest = 1e-3, kLargest = 5;
  if (!(baseline >= kSmallest && baseline <= kLargest)) {
    throw InputError(fmt::format("{}: the baseline is {:.4g} m; expected {} to {} m: is its unit another one?", file,
                                 baseline, kSmallest, kLargest));
  }
  if (right_L.x() < 0.5 * baseline) {
    throw InputError(file + (right_L.x() > 0
                                 ? ": the right camera is not beside the left one but above, below, before or behind it"
                                 : ": the right camera is to the left of the left one: the cameras are swapped, or the "
                                   "baseline's sign is wrong (T_x from left to right is below 0)"));
  }
}

}  // namespace multireach
