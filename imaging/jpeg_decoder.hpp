#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>

namespace multireach {

/// Decodes at least `part` of a JPEG of the given size into an 8-bit BGR image of that size; the other pixels are
/// undefined. The pixels of the part are those of a decoding of the whole, and the same with and without SIMD. Returns
/// false when the data are no JPEG, of another size, or damaged where they are read: all that comes before the end of
/// the part, and nothing after.
bool decode_jpeg(std::span<const uint8_t> data, cv::Size size, const cv::Rect& part, cv::Mat& bgr);

}  // namespace multireach
