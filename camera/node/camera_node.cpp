#include "camera/node/camera_node.hpp"

#include "camera/pairing/stereo_message.hpp"
#include "runtime/channels.hpp"

namespace multireach {

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
  send(out, channel::kStereoImages,
       stereo_message(pair->utime, std::move(pair->left), std::move(pair->right), sequence_++));
}

}  // namespace multireach
