#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/colour/blob.hpp"
#include "vision/contour/sphere_contour.hpp"
#include "vision/track/candidates.hpp"

namespace multireach::vision {

/// Which colours count as the target's: those learned, or also those near them. The latter are enough where little else
/// can be meant: in the small window in which a confirmed target is expected.
enum class Colours { kLearned, kWider };

/// What was found of one target in one image of a pair.
struct View {
  enum class Content {
    kNotSearched,
    kWrongImage,  ///< not searched: the image is not 8-bit BGR, or does not have the size of the calibration
    kDark,        ///< the whole search area was searched, contains no blob, and is black
    kFilled,      ///< most of the search area has the target's colour: nothing was measured
    kBlobs,       ///< `blobs`, or none
  };
  Content content = Content::kNotSearched;
  Colours colours = Colours::kLearned;  ///< the colours that were searched for
  bool whole = false;                   ///< the whole search area was searched
  bool full = false;                    ///< as many blobs were found as are measured: there may be more
  cv::Rect window;                      ///< search window
  cv::Mat bgr;                          ///< the image; shares its pixels
  std::vector<Blob> blobs;
  std::vector<SphereContour> contours;  ///< one per blob
  std::vector<Appearance> appearance;   ///< likewise

  bool wider() const { return colours == Colours::kWider; }
  /// Whether a blob is as compact as an ellipse of 5:2, or a disc with much missing.
  bool is_compact(int blob) const { return appearance[static_cast<size_t>(blob)].compactness > 0.4; }
};

}  // namespace multireach::vision
