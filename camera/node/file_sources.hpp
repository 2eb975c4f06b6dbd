#pragma once

#include <memory>
#include <string>

#include "camera/node/camera_node.hpp"

namespace multireach {

struct ImagesOptions {
  std::string left, right;  ///< a file, a folder, or a pattern with * and ?; the same number of files in each
  int64_t rate_hz = 30;
  int64_t repeat = 1;  ///< how often the whole list is sent
  int64_t origin_utime = 0;
  int jpeg_quality = 95;  ///< of files that are not JPEG; 0 sends raw BGR. JPEG files are sent as they are
};

/// Pairs of image files in the order of their names. Throws InputError when there is none, their numbers differ, or one
/// cannot be read.
std::unique_ptr<CameraSource> make_images_source(const ImagesOptions& options);

}  // namespace multireach
