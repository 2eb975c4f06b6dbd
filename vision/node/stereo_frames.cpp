#include "vision/node/stereo_frames.hpp"

#include <charconv>

#include "imaging/jpeg_decoder.hpp"
#include "runtime/digest.hpp"
#include "runtime/image_message.hpp"
#include "runtime/message.hpp"

namespace multireach {
namespace {

int64_t sequence_of(const images_t& images) {
  for (const image_t& image : images.images) {
    for (const image_metadata_t& item : image.metadata) {
      if (item.key != "sequence") continue;
      int64_t value = -1;
      const char* begin = reinterpret_cast<const char*>(item.value.data());
      const auto [end, error] = std::from_chars(begin, begin + item.value.size(), value);
      if (error == std::errc() && end == begin + item.value.size() && value >= 0) return value;
    }
  }
  return -1;
}

const image_t* image_of_type(const images_t& images, int16_t type) {
  for (size_t i = 0; i < images.images.size(); ++i) {
    if (images.image_types[i] == type) return &images.images[i];
  }
  return nullptr;
}

}  // namespace

StereoFrames::StereoFrames(std::span<const uint8_t> message) {
  auto images = decode<images_t>(message);
  if (!images) return;
  images_ = std::make_unique<images_t>(std::move(*images));
  pair_sequence_ = sequence_of(*images_);
  sides_[index(Side::kLeft)].image = image_of_type(*images_, images_t::LEFT);
  sides_[index(Side::kRight)].image = image_of_type(*images_, images_t::RIGHT);
}

int64_t StereoFrames::frame_utime(Side side) const {
  const image_t* image = sides_[index(side)].image;
  return image ? image->utime : -1;
}

bool StereoFrames::has(Side side, int width, int height) const {
  const image_t* image = sides_[index(side)].image;
  return image && image->width == width && image->height == height;
}

int64_t StereoFrames::fingerprint(Side side) const {
  constexpr int64_t kExactInADouble = (int64_t{1} << 53) - 1;
  const image_t* image = sides_[index(side)].image;
  return image ? digest_of(image->data) & kExactInADouble : 0;
}

bool StereoFrames::chroma_subsampled(Side side) const {
  const image_t* image = sides_[index(side)].image;
  if (!image) return false;
  switch (image->pixelformat) {
    case image_t::PIXEL_FORMAT_YUYV:
    case image_t::PIXEL_FORMAT_UYVY:
    case image_t::PIXEL_FORMAT_I420:
    case image_t::PIXEL_FORMAT_NV12:
      return true;
    case image_t::PIXEL_FORMAT_MJPEG:
      return jpeg_chroma_subsampled(image->data);
    default:
      return false;
  }
}

const cv::Mat* StereoFrames::pixels(Side side, const cv::Rect& part, ImageCodec& codec) {
  OneSide& one = sides_[index(side)];
  if (!one.image) return nullptr;
  if ((one.valid & part) == part) return &one.bgr;
  one.valid = {};
  if (!codec.decode(encoded(*one.image), part, one.bgr)) return nullptr;
  one.valid = part;
  return &one.bgr;
}

}  // namespace multireach
