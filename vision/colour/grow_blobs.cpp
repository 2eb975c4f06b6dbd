#include "vision/colour/grow_blobs.hpp"

#include <algorithm>

namespace multireach::vision {
namespace {

// Choices, made with the marbled ball of docs/real-images.md in view: below kRagged, a blob is hardly a whole object
// (half a disc has 0.5); an object is as compact as join_parts() asks for, and kMore times as compact as its part.
constexpr double kRagged = 0.6, kCompact = 0.7, kMore = 1.3;
constexpr double kMostArea = 5;  // areas of the part: what is larger is rather the background

/// Whether the border of the part of the image that was searched cuts a box off, where `area` goes on.
bool is_cut_off(const cv::Rect& box, const cv::Rect& searched, const cv::Rect& area) {
  return (box.x == searched.x && searched.x > area.x) || (box.y == searched.y && searched.y > area.y) ||
         (box.br().x == searched.br().x && searched.br().x < area.br().x) ||
         (box.br().y == searched.br().y && searched.br().y < area.br().y);
}

}  // namespace

bool is_ragged(const Blob& blob) {
  return compactness(blob) < kRagged;
}

cv::Rect surroundings_of(const Blob& blob) {
  const int margin = std::max(blob.box.width, blob.box.height);
  return {blob.box.x - margin, blob.box.y - margin, blob.box.width + 2 * margin, blob.box.height + 2 * margin};
}

const Blob* whole_of(const Blob& ragged, std::span<const Blob> of_wider_colours, const cv::Rect& searched,
                     const cv::Rect& area) {
  const double least = std::max(kCompact, kMore * compactness(ragged));
  const auto is_whole = [&](const Blob& other) {
    return other.area < kMostArea * ragged.area && compactness(other) >= least &&
           2 * static_cast<double>(common_pixels(other, ragged)) > ragged.area &&
           !is_cut_off(other.box, searched, area);
  };
  const auto found = std::ranges::find_if(of_wider_colours, is_whole);
  return found == of_wider_colours.end() ? nullptr : &*found;
}

}  // namespace multireach::vision
