#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/colour/blob.hpp"
#include "vision/contour/sphere_contour.hpp"
#include "vision/track/candidates.hpp"

namespace multireach::vision {

/// What was found of one target in one image of a pair.
struct View {
  bool fits = false;    ///< the image is 8-bit BGR and has the size of the calibration
  bool whole = false;   ///< the whole search area was searched
  bool dark = false;    ///< nothing was found in the whole search area, and it is black
  bool filled = false;  ///< most of the search area has the target's colour
  bool wider = false;   ///< searched with the wider colour model
  bool full = false;    ///< as many blobs were found as are measured: there may be more
  cv::Rect window;      ///< search window
  cv::Mat bgr;          ///< the image; shares its pixels
  std::vector<Blob> blobs;
  std::vector<SphereContour> contours;  ///< one per blob
  std::vector<Appearance> appearance;   ///< likewise
};

}  // namespace multireach::vision
