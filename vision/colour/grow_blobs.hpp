#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "vision/colour/blob.hpp"

namespace multireach::vision {

/// Whether a blob is much less compact than a disc. It may be a part of an object whose other parts have colours just
/// beyond the limits.
bool has_low_compactness(const Blob& blob);

/// The part of an image in which the object around a blob is searched for: the blob's box and, on each side, its longer
/// side.
cv::Rect surroundings_of(const Blob& blob);

/// What a blob of low compactness grows to.
struct GrownBlob {
  const Blob* blob = nullptr;  ///< null: nothing that it may be a part of was found
  bool cut_off = false;        ///< the search ended in the middle of it: a larger part of the image may show it all
};

/// Hysteresis thresholding, as of edges (Canny 1986), by colours: the blob of wider colours, of those found in the part
/// `searched` of an image, that contains most of `seed`, if it is compact, clearly more so than the seed, less than
/// five times as large, and not cut off where the search ends inside `area`, the part of the image that counts.
GrownBlob grown_blob(const Blob& seed, std::span<const Blob> of_wider_colours, const cv::Rect& searched,
                     const cv::Rect& area);

}  // namespace multireach::vision
