#include "vision/colour/grow_blobs.hpp"

#include <algorithm>

namespace multireach::vision {
namespace {

// Choices, made with the marbled ball of docs/real-images.md in view. Half a disc has a compactness of 0.5; an object
// is as compact as join_parts() asks for, and kCompactnessGain times as compact as its part.
constexpr double kLowCompactness = 0.6, kCompact = 0.7, kCompactnessGain = 1.3;
constexpr double kMostArea = 5;  // areas of the part: what is larger is rather the background

/// Whether the border of the part of the image that was searched cuts a box off, where `area` goes on.
bool is_cut_off(const cv::Rect& box, const cv::Rect& searched, const cv::Rect& area) {
  return (box.x == searched.x && searched.x > area.x) || (box.y == searched.y && searched.y > area.y) ||
         (box.br().x == searched.br().x && searched.br().x < area.br().x) ||
         (box.br().y == searched.br().y && searched.br().y < area.br().y);
}

}  // namespace

bool has_low_compactness(const Blob& blob) {
  return compactness(blob) < kLowCompactness;
}

cv::Rect surroundings_of(const Blob& blob) {
  const int margin = std::max(blob.box.width, blob.box.height);
  return {blob.box.x - margin, blob.box.y - margin, blob.box.width + 2 * margin, blob.box.height + 2 * margin};
}

GrownBlob grown_blob(const Blob& seed, std::span<const Blob> of_wider_colours, const cv::Rect& searched,
                     const cv::Rect& area) {
  const double least = std::max(kCompact, kCompactnessGain * compactness(seed));
  const auto is_object = [&](const Blob& other) {
    return other.area < kMostArea * seed.area && compactness(other) >= least &&
           2 * static_cast<double>(common_pixels(other, seed)) > seed.area;
  };
  const auto found = std::ranges::find_if(of_wider_colours, is_object);
  if (found == of_wider_colours.end()) return {};
  const bool cut_off = is_cut_off(found->box, searched, area);
  return {cut_off ? nullptr : &*found, cut_off};
}

}  // namespace multireach::vision
