#pragma once

#include <opencv2/core.hpp>

#include "tools/calibrate/stereo_calibration.hpp"

namespace multireach {

/// Draws both image planes side by side, with all detected corners and their magnified residuals; poor pairs in red.
/// BGR.
cv::Mat reprojection_picture(const std::vector<BoardPair>& pairs, const StereoCalibration& calibration,
                             cv::Size image_size);

}  // namespace multireach
