#include "camera/devices/frame_converter.hpp"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <array>
#include <stdexcept>

namespace multireach {

struct FrameConverter::Handles {
  ImageCodec codec;
  tjhandle transform = tjInitTransform();
  cv::Mat bgr;

  Handles() {
    if (!transform) throw std::runtime_error("the JPEG library cannot be started");
  }
  ~Handles() { tjDestroy(transform); }
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
};

FrameConverter::FrameConverter(const FrameConversion& form) : form_(form), handles_(std::make_unique<Handles>()) {}
FrameConverter::~FrameConverter() = default;

std::string FrameConverter::refuse_size(const RawImage& image) {
  if (form_.width == 0) form_.width = image.width;
  if (form_.height == 0) form_.height = image.height;
  if (image.width != form_.width || image.height != form_.height) {
    return fmt::format("gives images of {} x {} pixels, not {} x {}", image.width, image.height, form_.width,
                       form_.height);
  }
  if (form_.side_by_side && image.width % 2) {
    return fmt::format("gives images {} pixels wide, which are not two of the same width", image.width);
  }
  return "";
}

std::variant<std::vector<Frame>, std::string> FrameConverter::convert(RawImage image, int64_t utime) {
  if (std::string fault = refuse_size(image); !fault.empty()) return fault;
  const bool jpeg = image.format == PixelFormat::kMjpeg;
  if (form_.side_by_side || form_.rotate_180) {
    if (jpeg) {
      if (auto frames = transformed(image, utime); !frames.empty()) return frames;
    }
    return reencoded(image, utime);
  }
  if (!jpeg && form_.jpeg_quality > 0) return reencoded(image, utime);
  std::vector<Frame> frames(1);
  frames[0] = {.utime = utime,
               .width = image.width,
               .height = image.height,
               .row_stride = image.row_stride,
               .pixelformat = static_cast<int32_t>(image.format),
               .data = std::move(image.data)};
  return frames;
}

std::vector<Frame> FrameConverter::transformed(const RawImage& jpeg, int64_t utime) {
  const int parts = form_.side_by_side ? 2 : 1, width = jpeg.width / parts;
  std::array<tjtransform, 2> transforms{};
  std::array<unsigned char*, 2> data{};
  std::array<unsigned long, 2> sizes{};
  for (int part = 0; part < parts; ++part) {
    tjtransform& transform = transforms[static_cast<size_t>(part)];
    transform.op = form_.rotate_180 ? TJXOP_ROT180 : TJXOP_NONE;
    transform.options = TJXOPT_PERFECT;  // fails where JPEG blocks would be cut
    if (parts == 1) continue;
    transform.options |= TJXOPT_CROP;
    transform.r = {part * width, 0, width, jpeg.height};
  }
  std::vector<Frame> frames;
  if (tjTransform(handles_->transform, jpeg.data.data(), static_cast<unsigned long>(jpeg.data.size()), parts,
                  data.data(), sizes.data(), transforms.data(), TJFLAG_STOPONWARNING) == 0) {
    for (size_t part = 0; part < static_cast<size_t>(parts); ++part) {
      frames.push_back({.utime = utime,
                        .width = width,
                        .height = jpeg.height,
                        .row_stride = 0,
                        .pixelformat = static_cast<int32_t>(PixelFormat::kMjpeg),
                        .data = {data[part], data[part] + sizes[part]}});
    }
  }
  for (unsigned char* part : data) tjFree(part);
  return frames;
}

std::variant<std::vector<Frame>, std::string> FrameConverter::reencoded(const RawImage& image, int64_t utime) {
  cv::Mat& bgr = handles_->bgr;
  if (!handles_->codec.decode({image.width, image.height, image.row_stride, image.format, image.data}, bgr)) {
    return "gave an image that cannot be decoded";
  }
  // Rotating a packed image by 180 degrees reverses its pixels.
  if (form_.rotate_180) std::reverse(bgr.begin<cv::Vec3b>(), bgr.end<cv::Vec3b>());
  std::vector<Frame> frames;
  const int parts = form_.side_by_side ? 2 : 1, width = bgr.cols / parts;
  for (int part = 0; part < parts; ++part) {
    frames.push_back(
        frame_of(handles_->codec, bgr.colRange(part * width, (part + 1) * width), utime, form_.jpeg_quality));
  }
  return frames;
}

}  // namespace multireach
