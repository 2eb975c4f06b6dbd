#include "camera/node/camera_node.hpp"

#include "runtime/channels.hpp"

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

std::optional<int64_t> CameraNode::next_tick() const {
  if (finished_) return std::nullopt;
  return source_->next_utime();
}

void CameraNode::tick(Outbox& out) {
  auto pair = source_->next();
  if (!pair) {
    finished_ = !source_->waiting();
    return;
  }
  if (pair->truth) {
    pair->truth->sequence = pair->truth->pair_sequence = sequence_;
    send(out, channel::kTargetTruth, *pair->truth);
  }
  images_t images;
  images.utime = pair->utime;
  images.n_images = 2;
  images.image_types = {images_t::LEFT, images_t::RIGHT};
  images.images.push_back(message_of(std::move(pair->left), sequence_));
  images.images.push_back(message_of(std::move(pair->right), sequence_));
  ++sequence_;
  send(out, channel::kStereoImages, images);
}

}  // namespace multireach
