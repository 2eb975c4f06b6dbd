#pragma once

#include <opencv2/core.hpp>

#include "tools/calibrate/stereo_calibration.hpp"

namespace multireach {

/// Both images' planes beside each other, with all corners where they were seen and their residuals enlarged; poor
/// pairs in red. BGR.
cv::Mat reprojection_picture(const std::vector<BoardPair>& pairs, const StereoCalibration& calibration,
                             cv::Size image_size);

}  // namespace multireach
