#pragma once

#include <multireach/image_t.hpp>

#include "imaging/image_codec.hpp"

namespace multireach {

/// A view of an LCM image for the codec; the data stay in the message.
inline EncodedImage encoded(const image_t& image) {
  return {.width = image.width,
          .height = image.height,
          .row_stride = image.row_stride,
          .format = static_cast<PixelFormat>(image.pixelformat),
          .data = image.data};
}

}  // namespace multireach
