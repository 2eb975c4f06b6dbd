#pragma once

#include "tools/calibrate/stereo_calibration.hpp"

namespace multireach {

/// How uncertain a calibration is, by the corners that it was made from.
struct CalibrationErrors {
  RigErrors rig;
  double noise_px = 0;     ///< standard deviation of a corner's coordinate, by the residuals
  double view_factor = 1;  ///< how much larger variances are than if all corners had independent errors
};

/// Errors of a calibration: covariance of all parameters of both cameras and of their relative pose by least squares,
/// with the board's poses eliminated, scaled by the residuals, and mapped to the few errors of RigErrors. Errors that
/// the corners of one view share (the board is bent, or moves between the images) count for more than independent ones:
/// the covariance is scaled by how much more the views contradict each other. What all views share, as a wrong size of
/// the squares, does not show.
CalibrationErrors errors_of(const StereoCalibration& calibration, const Board& board, Lens lens);

/// Standard deviation (m, root of the trace) of a position on the left camera's axis by the errors of the calibration.
double axial_sigma_m(const StereoRig& rig, double distance_m);

}  // namespace multireach
