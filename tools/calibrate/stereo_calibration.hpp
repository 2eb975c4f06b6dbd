#pragma once

#include <functional>
#include <vector>

#include "tools/calibrate/chessboard.hpp"
#include "vision/stereo/triangulate.hpp"

namespace multireach {

/// The board in one pair of images.
struct BoardPair {
  Corners left, right;
};

/// Which of OpenCV's distortion coefficients are estimated; the others are 0.
enum class Lens {
  kRadtan,    ///< k1 k2 p1 p2
  kPlumbBob,  ///< and k3
  kRational,  ///< and k4 k5 k6
};

/// How well one pair of images fits the calibration, with the board where it fits both images best.
struct PairFit {
  double left_rms_px = 0, right_rms_px = 0;  ///< of the distances between corners and their projections
  Corners left_residuals, right_residuals;   ///< image less projection, pixels
  bool poor = false;                         ///< far worse than most
  bool used = true;

  double rms_px() const;
};

struct StereoCalibration {
  StereoRig rig;                             ///< X_WL is the identity
  double left_rms_px = 0, right_rms_px = 0;  ///< each camera by itself
  double stereo_rms_px = 0;                  ///< both together, of the pairs used, as cv::stereoCalibrate defines it
  double left_fx_sigma_px = 0, right_fx_sigma_px = 0;  ///< standard deviation of fx, each camera by itself
  std::vector<PairFit> fits;                           ///< one for each pair given
};

/// Calibrates both cameras from at least 3 pairs (Zhang's method, then all parameters of both together; OpenCV).
/// `square_m` gives the unit. Poor pairs are marked and, with `leave_out_poor`, not used. Throws std::runtime_error
/// when the pairs do not permit it: too few, or a focal length that would be known to 2 % only or worse.
StereoCalibration calibrate(const std::vector<BoardPair>& pairs, const Board& board, cv::Size image_size, Lens lens,
                            bool leave_out_poor);

/// How well corners fit that the calibration has not seen: each pair used is left out in turn, its corners are
/// triangulated by the cameras calibrated without it, and the board is laid into them (rigidly, so that its size
/// counts). Returns the distances in squares, of all corners, ascending. `progress` is told the part that is done.
std::vector<double> leave_one_out(const std::vector<BoardPair>& pairs, const Board& board, cv::Size image_size,
                                  Lens lens, const StereoCalibration& calibration,
                                  const std::function<void(double)>& progress);

}  // namespace multireach
