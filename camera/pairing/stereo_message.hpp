#pragma once

#include <multireach/images_t.hpp>

#include "camera/pairing/frame.hpp"

namespace multireach {

/// A pair as STEREO_IMAGES, with its number as metadata "sequence" of both images.
images_t stereo_message(int64_t utime, Frame left, Frame right, int64_t sequence);

}  // namespace multireach
