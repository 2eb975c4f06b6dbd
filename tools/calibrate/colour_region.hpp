#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace multireach {

/// The pixels of an image that show an object.
struct ObjectRegion {
  cv::Rect box;  ///< encloses them
  cv::Mat mask;  ///< of the image's size, 8-bit: 255 for these pixels, else 0
};

/// Proposes the region of the object that a click shows: connected pixels with colours like those around the click,
/// grown step by step from there, so that shadow and highlight are included, then cut from the surroundings by GrabCut.
/// `bgr`: 8-bit, contains the click.
ObjectRegion region_around(const cv::Mat& bgr, const cv::Point& click);

/// The union of the regions of several clicks.
ObjectRegion region_around(const cv::Mat& bgr, const std::vector<cv::Point>& clicks);

}  // namespace multireach
