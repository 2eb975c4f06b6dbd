#pragma once

#include <opencv2/imgcodecs.hpp>
#include <string>

#include "runtime/files.hpp"

namespace multireach {

/// An encoded image (PNG, JPEG and what else OpenCV reads) in memory; `name` says in errors where it is from. `flags`:
/// cv::IMREAD_COLOR (8-bit BGR) or cv::IMREAD_GRAYSCALE (8-bit). Throws InputError when it is none, or too large.
/// In the header, so that only those who read images link OpenCV's codecs.
inline cv::Mat decode_image(const std::vector<uint8_t>& bytes, const std::string& name, int flags) {
  cv::Mat image;
  try {
    if (!bytes.empty()) image = cv::imdecode(bytes, flags);
  } catch (const cv::Exception&) {  // more pixels than OpenCV takes
  }
  if (image.empty()) throw InputError(name + ": is not an image that can be read");
  return image;
}

/// The image in a file. Throws InputError as above, or when there is no such file.
inline cv::Mat read_image(const std::string& path, int flags = cv::IMREAD_COLOR) {
  return decode_image(read_binary_file(path), path, flags);
}

}  // namespace multireach
