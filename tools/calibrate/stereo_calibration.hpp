#pragma once

#include <functional>
#include <vector>

#include "tools/calibrate/chessboard.hpp"
#include "vision/stereo/triangulate.hpp"

namespace multireach {

/// The board's corners in one pair of images.
struct BoardPair {
  Corners left, right;
};

/// Which of OpenCV's distortion coefficients are estimated; the others are 0.
enum class Lens {
  kRadtan,    ///< k1 k2 p1 p2
  kPlumbBob,  ///< kRadtan and k3
  kRational,  ///< kPlumbBob and k4 k5 k6
};

/// How well one pair of images fits the calibration, for the board pose that fits both images best.
struct PairFit {
  double left_rms_px = 0, right_rms_px = 0;                ///< rms distance between corners and their projections
  Corners left_residuals, right_residuals;                 ///< image - projection, pixels
  Eigen::Isometry3d X_LB = Eigen::Isometry3d::Identity();  ///< maps the board's frame to the left camera's
  bool poor = false;                                       ///< far larger residuals than most pairs
  bool used = true;

  double rms_px() const;
};

struct StereoCalibration {
  StereoRig rig;                             ///< with its errors; X_WL is the identity
  double left_rms_px = 0, right_rms_px = 0;  ///< each camera calibrated alone
  double stereo_rms_px = 0;                  ///< both together, of the pairs used, as cv::stereoCalibrate defines it
  double left_fx_sigma_px = 0, right_fx_sigma_px = 0;  ///< standard deviation of fx, each camera by itself
  std::vector<PairFit> fits;                           ///< one for each pair given

  /// Whether both cameras together leave residuals more than twice those of each camera alone: the two images of many
  /// pairs do not show the board in one pose.
  bool pairs_contradict() const;
};

/// Calibrates both cameras from at least 3 pairs: Zhang's method for each camera, then all parameters of both together
/// (OpenCV). `square_m` sets the unit. Poor pairs are marked and, with `leave_out_poor`, not used. Throws
/// std::runtime_error when the pairs do not suffice: too few, or an uncertainty of a focal length of 2 % or more.
StereoCalibration calibrate(const std::vector<BoardPair>& pairs, const Board& board, cv::Size image_size, Lens lens,
                            bool leave_out_poor);

/// Cross-validation: each used pair is left out in turn, its corners are triangulated with cameras calibrated without
/// it, and the board is fitted to them (rigidly, so that errors of scale count). Returns the distances of all corners
/// from the board in squares, ascending. `progress` receives the part done.
std::vector<double> leave_one_out(const std::vector<BoardPair>& pairs, const Board& board, cv::Size image_size,
                                  Lens lens, const StereoCalibration& calibration,
                                  const std::function<void(double)>& progress);

}  // namespace multireach
