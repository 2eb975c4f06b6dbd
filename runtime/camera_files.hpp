#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "imaging/stereo_rig.hpp"
#include "runtime/files.hpp"

namespace multireach {

/// Whether coefficients of a lens's distortion can be computed with. Beyond 1e9, which no lens needs, finding a ray
/// takes seconds.
bool are_usable(std::span<const double> distortion);
/// What are_usable() expects, for error messages.
constexpr char kUsableDistortion[] = "numbers of -1e9 to 1e9";

/// File format of a stereo calibration.
enum class CameraFormat {
  kVision,  ///< vision.yaml, section `cameras`: left, right, left_to_right, errors, left_to_robot
  kOpenCv,  ///< M1 D1 M2 D2 R T (R1 R2 P1 P2 Q) as OpenCV YAML, in one file or two (intrinsics, extrinsics)
  kRos,     ///< two ROS camera_info files: left, right
  kKalibr,  ///< Kalibr's camchain: cam0 (left), cam1 (right), T_cn_cnm1
};

/// "vision", "opencv", "ros", "kalibr"; throws InputError that names `option` for another word.
CameraFormat camera_format_of(const std::string& option, const std::string& word);
/// The format guessed from the file names: two files are ROS, *camchain* is Kalibr, .yml is OpenCV, anything else is a
/// vision file.
CameraFormat format_from_names(const std::vector<std::string>& paths);
/// Length of one `unit` ("m", "cm", "mm" or "inch") in metres; throws InputError that names `option` for another word.
double unit_length_m(const std::string& option, const std::string& unit);

/// What the caller knows about the calibration. Throws InputError where a file contradicts it.
struct CameraFileHints {
  std::optional<int> width, height;  ///< of both images, pixels
  std::optional<double> unit_m;      ///< length unit of T, in metres
};

struct CameraFiles {
  CameraFormat format = CameraFormat::kVision;
  StereoRig rig;                         ///< X_WL is the identity unless `has_robot_pose`
  bool has_robot_pose = false;           ///< X_WL was read from the section left_to_robot of a vision file
  std::vector<std::string> assumptions;  ///< one sentence for each assumption about data that the files lack
};

/// Reads a calibration; the keys in the files determine the format. Throws InputError that names file, line and key
/// when something is missing or malformed, or when `check_rig` refuses the result.
CameraFiles read_camera_files(const std::vector<std::string>& paths, const CameraFileHints& hints = {});

/// Throws InputError that names `file` for an impossible rig: no image size, a focal length that is not positive, a
/// baseline that is zero, below 1 mm or above 5 m (a wrong unit), or a right camera that is not to the right of the
/// left one (swapped cameras, or a wrong sign).
void check_rig(const StereoRig& rig, const std::string& file);

}  // namespace multireach
