#pragma once

#include <span>
#include <vector>

#include "vision/colour/blob.hpp"

namespace multireach::vision {

/// The blobs of one image, with those joined that are parts of one compact object, as the panels of a basketball
/// between its dark seams. Blobs are beside each other if for most of the smaller one's diameter only a gap of at most
/// a seam's width is between them. Those beside each other are joined, after what makes the others together more
/// compact is left out, as a hand, if their union has a compactness of at least 0.7, above the mean of theirs by area,
/// and a diameter of at least 40 pixels. Parts of what is not compact stay as they are, and tell what they may be parts
/// of. By decreasing area.
std::vector<Blob> join_parts(std::span<const Blob> blobs);

}  // namespace multireach::vision
