#pragma once

#include <memory>
#include <string>

#include "tools/log/import/image_source.hpp"

namespace multireach {

/// Two videos, of the left and of the right camera, whose first images were taken at the same time.
struct VideoOptions {
  std::string left, right;
  std::optional<double> rate_hz;  ///< images per second; default: as the files say
  int64_t origin_utime = 0;       ///< time of the first images, microseconds
  int jpeg_quality = 95;          ///< 0: raw
};

/// Opens both. Image k of a video is k periods later than the first. Throws InputError when one cannot be opened, or
/// when a rate is missing or differs from the other's.
std::unique_ptr<ImageSource> open_videos(const VideoOptions& options);

}  // namespace multireach
