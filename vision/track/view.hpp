#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/colour/blob.hpp"
#include "vision/contour/sphere_contour.hpp"
#include "vision/track/candidates.hpp"

namespace multireach::vision {

/// Which colours count as the target's: the learned ones, or also those near them. The latter are enough only where
/// little else can be meant: in the small window in which a confirmed target is expected.
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
  bool growth_cut_off = false;          ///< what a blob would grow to is cut off where the search ended
  cv::Rect window;                      ///< search window
  cv::Mat bgr;                          ///< the image; shares its pixels
  std::vector<Blob> blobs;              ///< of the colours, or grown from them by the wider colours (grow_blobs)
  std::vector<Blob> seeds;              ///< what the colours show of each blob: all of it, or a part
  std::vector<SphereContour> contours;  ///< one per blob
  std::vector<Appearance> appearance;   ///< likewise

  bool wider() const { return colours == Colours::kWider; }
  /// Whether only the wider colours show all of a blob.
  bool shows_more_than_learned(int blob) const {
    return wider() || blobs[static_cast<size_t>(blob)].area > seeds[static_cast<size_t>(blob)].area;
  }
  /// Whether a blob is as compact as an ellipse of 5:2, or a disc with much missing.
  bool is_compact(int blob) const { return appearance[static_cast<size_t>(blob)].compactness > 0.4; }
};

}  // namespace multireach::vision
