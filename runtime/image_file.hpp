#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace multireach {

/// Decodes a PNG or JPEG file to an 8-bit BGR image; errors call it `name`. Transparency is ignored, 16-bit channels
/// lose their lower byte, and EXIF orientation is not applied. Throws InputError when the bytes are not such an image,
/// are damaged, or hold more than 2^28 pixels.
cv::Mat decode_image(const std::vector<uint8_t>& bytes, const std::string& name);

/// Reads and decodes an image file. Throws InputError as above, or when there is no such file.
cv::Mat read_image(const std::string& path);

/// Encodes an 8-bit BGR or grey image as PNG. Throws InputError when memory runs out.
std::vector<uint8_t> encode_png(const cv::Mat& image);

}  // namespace multireach
