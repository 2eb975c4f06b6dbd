#pragma once

#include <span>
#include <vector>

#include "vision/colour/blob.hpp"

namespace multireach::vision {

/// The blobs of one image, with those joined that are parts of one compact object, as the panels of a basketball
/// between its dark seams. Adjacent blobs have a gap of at most a seam's width between them, for most of the smaller
/// one's diameter. A union is an object if it has a compactness of at least 0.7, above the mean of its parts by area,
/// and a diameter of at least 40 pixels; what makes it less compact is left out first, as a hand. Its
/// alternative is one of its parts. Adjacent blobs that are no object together are returned unchanged, with their union
/// as their alternative, except discs (compactness above 0.96). By decreasing area;
/// `blobs` as well, for a group begins at the largest.
std::vector<Blob> join_parts(std::span<const Blob> blobs);

}  // namespace multireach::vision
