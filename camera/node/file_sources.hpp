#pragma once

#include <memory>
#include <string>

#include "camera/node/camera_node.hpp"

namespace multireach {

struct ImagesOptions {
  std::string left, right;  ///< a file, a folder, or a pattern with * and ?; both with the same number of files
  int64_t rate_hz = 30;
  int64_t repeat = 1;  ///< number of times the whole list is sent
  int64_t origin_utime = 0;
  int jpeg_quality = 95;  ///< for files that are not JPEG; 0 sends raw BGR. JPEG files are sent unchanged
};

/// Reads pairs of image files, sorted by name. Throws InputError when there is none, the numbers of left and right
/// files differ, or a file cannot be read.
std::unique_ptr<CameraSource> make_images_source(const ImagesOptions& options);

}  // namespace multireach
