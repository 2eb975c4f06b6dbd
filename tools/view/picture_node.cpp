#include "tools/view/picture_node.hpp"

#include <multireach/debug_request_t.hpp>
#include <multireach/images_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/files.hpp"

namespace multireach {
namespace {

bool is_jpeg(const image_t& image) {
  return image.pixelformat == image_t::PIXEL_FORMAT_MJPEG && image.size > 3 && image.data[0] == 0xff &&
         image.data[1] == 0xd8;
}

}  // namespace

std::vector<std::string_view> PictureNode::inputs() const {
  return {channel::kVisionDebug};
}

Receipt PictureNode::receive(std::string_view, std::span<const uint8_t> bytes, Outbox&) {
  auto images = decode<images_t>(bytes);
  if (!images || images->images.size() != 1 || !is_jpeg(images->images[0])) {
    ++counters_.refused;
    return {};
  }
  ++counters_.received;
  ++pictures_;
  unwritten_ = std::move(images->images[0].data);
  return {};
}

void PictureNode::tick(Outbox& out) {
  if (ticks_++ % kTicksPerRequest == 0) {
    debug_request_t request;
    request.utime = next_tick_us_;
    send(out, channel::kVisionDebugRequest, request);
  }
  next_tick_us_ += kPeriodUs;
  flush();
}

void PictureNode::flush() {
  if (unwritten_.empty()) return;
  OutputFile file(path_);
  file.write(unwritten_);
  file.finish();
  unwritten_.clear();
}

}  // namespace multireach
