#include "camera/pairing/stereo_message.hpp"

#include <string>
#include <utility>

namespace multireach {
namespace {

image_t message_of(Frame&& frame, int64_t sequence) {
  image_t image;
  image.utime = frame.utime;
  image.width = frame.width;
  image.height = frame.height;
  image.row_stride = frame.row_stride;
  image.pixelformat = frame.pixelformat;
  image.size = static_cast<int32_t>(frame.data.size());
  image.data = std::move(frame.data);
  image_metadata_t count;
  const std::string number = std::to_string(sequence);
  count.key = "sequence";
  count.n = static_cast<int32_t>(number.size());
  count.value.assign(number.begin(), number.end());
  image.nmetadata = 1;
  image.metadata.push_back(std::move(count));
  return image;
}

}  // namespace

images_t stereo_message(int64_t utime, Frame left, Frame right, int64_t sequence) {
  images_t images;
  images.utime = utime;
  images.n_images = 2;
  images.image_types = {images_t::LEFT, images_t::RIGHT};
  images.images.push_back(message_of(std::move(left), sequence));
  images.images.push_back(message_of(std::move(right), sequence));
  return images;
}

}  // namespace multireach
