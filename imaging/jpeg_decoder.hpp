#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <span>

namespace multireach {

/// Decodes at least `part` of a JPEG of the given size into an 8-bit BGR image of that size; the other pixels are
/// undefined. The part's pixels are the same as when the whole image is decoded, with and without SIMD. Returns false
/// when the data are not a JPEG, have another size, or are damaged before the end of the part; data after it are not
/// read.
[[nodiscard]] bool decode_jpeg(std::span<const uint8_t> data, cv::Size size, const cv::Rect& part, cv::Mat& bgr);

/// Width and height of a JPEG, from its header; nothing when the data do not start with one.
[[nodiscard]] std::optional<cv::Size> jpeg_size(std::span<const uint8_t> data);

/// Whether the header of a JPEG says that its chroma has a lower resolution than its luma.
[[nodiscard]] bool jpeg_chroma_subsampled(std::span<const uint8_t> data);

}  // namespace multireach
