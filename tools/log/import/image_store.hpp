#pragma once

#include <span>
#include <string>
#include <vector>

#include "camera/pairing/frame.hpp"
#include "imaging/image_codec.hpp"

namespace multireach {

/// Makes recorded images images of a session: JPEG data stay as they are, others become JPEG, or raw with quality 0.
class ImageStore {
 public:
  explicit ImageStore(int jpeg_quality) : jpeg_quality_(jpeg_quality) {}

  /// The content of an image file; errors call it `name`. Throws InputError as decode_image does.
  Frame file_frame(std::vector<uint8_t> bytes, const std::string& name, int64_t utime);
  /// An uncompressed image. Throws InputError that names `name` when the data do not suffice for the size.
  Frame raw_frame(const EncodedImage& image, const std::string& name, int64_t utime);

 private:
  int jpeg_quality_;
  ImageCodec codec_;
};

}  // namespace multireach
