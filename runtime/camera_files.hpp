#pragma once

#include <optional>
#include <string>
#include <vector>

#include "imaging/stereo_rig.hpp"
#include "runtime/files.hpp"

namespace multireach {

/// How a calibration of two cameras is written down.
enum class CameraFormat {
  kVision,  ///< section `cameras` of a vision file: left, right, left_to_right, left_to_robot
  kOpenCv,  ///< M1 D1 M2 D2 R T (R1 R2 P1 P2 Q) in OpenCV's YAML, in one file or two (intrinsics, extrinsics)
  kRos,     ///< two files of camera_info: left, right
  kKalibr,  ///< Kalibr's camchain: cam0 (left), cam1 (right), T_cn_cnm1
};

/// "vision", "opencv", "ros", "kalibr"; throws InputError that names `option` for another word.
CameraFormat camera_format_of(const std::string& option, const std::string& word);
/// The format that files of these names have unless something else is said: two are ROS's, *camchain* is Kalibr's, .yml
/// OpenCV's, anything else a vision file's.
CameraFormat usual_format(const std::vector<std::string>& paths);
/// Metres in a unit "m", "cm", "mm" or "inch"; throws InputError that names `option` for another word.
double metres_in(const std::string& option, const std::string& unit);

/// What the one who asks knows of the files. Where they say it themselves, they must agree.
struct CameraFileHints {
  std::optional<int> width, height;  ///< of both images, pixels
  std::optional<double> unit_m;      ///< metres in the unit of T
};

struct CameraFiles {
  CameraFormat format = CameraFormat::kVision;
  StereoRig rig;                     ///< X_WL is the identity unless `knows_robot`
  bool knows_robot = false;          ///< the files say where the left camera is: section left_to_robot of a vision file
  std::vector<std::string> assumed;  ///< sentences on what the files do not say and what was taken instead
};

/// Reads a calibration, whose format is told by its keys. Throws InputError that names file, line and key for what is
/// missing or malformed, and for what `check_rig` refuses.
CameraFiles read_camera_files(const std::vector<std::string>& paths, const CameraFileHints& hints = {});

/// The texts of the files that hold this rig: one, or left and right for ROS. Positions in metres. Throws InputError
/// when the format has no place for the lens: Kalibr's radtan ends at p2. `robot`: with left_to_robot (vision files
/// only).
std::vector<std::string> camera_file_texts(const StereoRig& rig, CameraFormat format, bool robot = false);

/// X_WL as a vision file's section left_to_robot has it, `indent` deep.
std::string transform_text(const Eigen::Isometry3d& X, const std::string& indent);

/// Throws InputError that names `file` for a rig that cannot be: no image size, a focal length that is not positive, no
/// baseline or one of less than 1 mm or more than 5 m (a wrong unit), a right camera that is not to the right of the
/// left one (swapped, or the wrong sign).
void check_rig(const StereoRig& rig, const std::string& file);

}  // namespace multireach
