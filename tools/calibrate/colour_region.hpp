#pragma once

#include <opencv2/core.hpp>

namespace multireach {

/// Bounding rectangle of the object that a click shows: of the connected pixels around it that have about its colour.
/// `bgr`: 8-bit, contains the click.
cv::Rect region_around(const cv::Mat& bgr, const cv::Point& click);

}  // namespace multireach
