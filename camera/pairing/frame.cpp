#include "camera/pairing/frame.hpp"

namespace multireach {

Frame frame_of(ImageCodec& codec, const cv::Mat& bgr, int64_t utime, int jpeg_quality) {
  Frame frame{.utime = utime,
              .width = bgr.cols,
              .height = bgr.rows,
              .row_stride = 0,
              .pixelformat = static_cast<int32_t>(PixelFormat::kMjpeg),
              .data = {}};
  if (jpeg_quality > 0) {
    frame.data = codec.encode_jpeg(bgr, jpeg_quality);
    return frame;
  }
  const cv::Mat packed = bgr.isContinuous() ? bgr : bgr.clone();
  frame.pixelformat = static_cast<int32_t>(PixelFormat::kBgr);
  frame.row_stride = static_cast<int>(packed.step);
  frame.data.assign(packed.data, packed.data + packed.total() * packed.elemSize());
  return frame;
}

}  // namespace multireach
