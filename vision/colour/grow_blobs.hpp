#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "vision/colour/blob.hpp"

namespace multireach::vision {

/// Whether a blob may be a part of an object whose other parts have colours just beyond the limits, as in its shadow.
bool is_ragged(const Blob& blob);

/// The part of an image in which what a blob may be a part of is searched for: three times its size.
cv::Rect surroundings_of(const Blob& blob);

/// What a ragged blob is a part of: the blob of wider colours, of those found in the part `searched` of an image, that
/// contains most of it, if that is compact, clearly more so than the ragged one, less than five times as large, and not
/// cut off where the search ends inside `area`, the part of the image that counts. Null if there is none. This is
/// thresholding with hysteresis, as of edges (Canny 1986), by colours.
const Blob* whole_of(const Blob& ragged, std::span<const Blob> of_wider_colours, const cv::Rect& searched,
                     const cv::Rect& area);

}  // namespace multireach::vision
