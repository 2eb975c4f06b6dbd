#pragma once

#include <string>

#include "tools/log/import/image_source.hpp"

namespace multireach {

/// What an import has written.
struct ImportSummary {
  int64_t pairs = 0, unpaired = 0;
  int64_t period_us = 0;  ///< median time between images of a camera
  int64_t max_skew_us = 0, median_skew_us = 0;
  int width = 0, height = 0;  ///< of the first left image
  double span_s = 0;
  std::string warning;  ///< a sentence, or ""

  std::string text() const;
};

/// Writes the image pairs of a recording into a log, as STEREO_IMAGES at their times. Throws InputError when the
/// recording cannot be read or no two images are close enough in time, OutputError when the log cannot be written.
ImportSummary import_images(const ImportOptions& options, const std::string& output,
                            const ImageSource::Progress& progress);
/// The same of a source that is open; `options.input` names it in errors.
ImportSummary import_images(ImageSource& source, const ImportOptions& options, const std::string& output,
                            const ImageSource::Progress& progress);

}  // namespace multireach
