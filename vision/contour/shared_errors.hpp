#pragma once

#include <Eigen/Core>

namespace multireach::vision {

/// Errors that the two images of a pair share, since their cause is the same for both: each column is the error of
/// (x/z, y/z, s) by one standard deviation of that cause, in the image at hand. They move a position across the line of
/// sight, but hardly along it, for disparity is a difference. Only kGammaCurve moves it along that line, too, where the
/// two images show other things behind the object.
enum SharedError {
  kLight,       ///< the edges of the lit and of the dark side are biased differently
  kOccluded,    ///< a part of the object may be occluded that the blob's centroid does not know of
  kShape,       ///< the object that the border of the image cuts off may have another shape than its blob tells
  kGammaCurve,  ///< the camera may have a gamma curve, which moves edges to their darker side
  kSharedErrors
};
using SharedErrors = Eigen::Matrix<double, 3, kSharedErrors>;

}  // namespace multireach::vision
