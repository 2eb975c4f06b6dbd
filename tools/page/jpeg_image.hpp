#pragma once

#include <multireach/image_t.hpp>
#include <string>

#include "imaging/image_codec.hpp"

namespace multireach {

/// Whether an image of a message is a JPEG, which browsers show as it is.
bool is_jpeg(const image_t& image);

/// The image as a JPEG: as it came, or encoded and, where it is wider than `width` pixels, made smaller. `smaller`:
/// also a JPEG that is wider is made smaller. Empty when it cannot be decoded.
std::string jpeg_of(const image_t& image, ImageCodec& codec, int width, bool smaller);

}  // namespace multireach
