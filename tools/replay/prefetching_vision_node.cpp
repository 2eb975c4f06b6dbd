#include "tools/replay/prefetching_vision_node.hpp"

#include <algorithm>

#include "runtime/channels.hpp"

namespace multireach {
namespace {

constexpr int64_t kPrefetchDepth = 24;  // messages decoded ahead; some 300 MB with full-HD images

}  // namespace

PrefetchingVisionNode::PrefetchingVisionNode(const ReplayOptions& options)
    : vision_(*options.vision), session_(options.session, options.from, false) {
  const int threads = std::max(1, options.threads - 1);  // one of them runs the loop
  for (int i = 0; i < threads; ++i) {
    threads_.emplace_back([this] {
      try {
        work();
      } catch (...) {
        const std::lock_guard lock(mutex_);
        failure_ = std::current_exception();
        changed_.notify_all();
      }
    });
  }
}

PrefetchingVisionNode::~PrefetchingVisionNode() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void PrefetchingVisionNode::work() {
  ImageCodec codec;
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stop_ || started_ < processed_ + kPrefetchDepth; });
    auto input = session_.next();
    while (input && input->channel != channel::kStereoImages) input = session_.next();
    if (!input || stop_) return;
    const int64_t index = started_++;
    lock.unlock();
    StereoFrames frames(input->data);
    for (const auto& [side, camera] :
         {std::pair(Side::kLeft, &vision_.config().rig.left), {Side::kRight, &vision_.config().rig.right}}) {
      if (frames.is_valid() && frames.has(side, camera->width, camera->height))
        frames.pixels(side, {0, 0, camera->width, camera->height}, codec);
    }
    lock.lock();
    decoded_.emplace(index, std::move(frames));
    if (index == processed_) changed_.notify_all();
  }
}

Receipt PrefetchingVisionNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) {
  if (channel != channel::kStereoImages) return vision_.receive(channel, bytes, out);
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return decoded_.contains(processed_) || failure_; });
  if (!decoded_.contains(processed_)) std::rethrow_exception(failure_);
  StereoFrames frames = std::move(decoded_.extract(processed_).mapped());
  ++processed_;
  // Wake the threads only when there is room for many images.
  if (started_ <= processed_ + kPrefetchDepth / 2) changed_.notify_all();
  lock.unlock();
  return vision_.process(frames, out);
}

}  // namespace multireach
