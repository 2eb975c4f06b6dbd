#include "tools/replay/vision_ahead.hpp"

#include "runtime/channels.hpp"

namespace multireach {
namespace {

constexpr int64_t kAhead = 24;  // messages decoded ahead; some 300 MB with full-HD images

}  // namespace

VisionAhead::VisionAhead(const ReplayOptions& options)
    : vision_(*options.vision), session_(options.session, options.from, false) {
  for (int i = 0; i < options.threads; ++i) {
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

VisionAhead::~VisionAhead() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void VisionAhead::work() {
  ImageCodec codec;
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stop_ || begun_ < concluded_ + kAhead; });
    auto input = session_.next();
    while (input && input->channel != channel::kStereoImages) input = session_.next();
    if (!input || stop_) return;
    const int64_t index = begun_++;
    lock.unlock();
    StereoFrames frames(input->data);
    for (const auto& [side, camera] :
         {std::pair(Side::kLeft, &vision_.config().rig.left), {Side::kRight, &vision_.config().rig.right}}) {
      if (frames.decoded() && frames.has(side, camera->width, camera->height))
        frames.pixels(side, {0, 0, camera->width, camera->height}, codec);
    }
    lock.lock();
    opened_.emplace(index, std::move(frames));
    if (index == concluded_) changed_.notify_all();
  }
}

Receipt VisionAhead::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) {
  if (channel != channel::kStereoImages) return vision_.receive(channel, bytes, out);
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return opened_.contains(concluded_) || failure_; });
  if (!opened_.contains(concluded_)) std::rethrow_exception(failure_);
  StereoFrames frames = std::move(opened_.extract(concluded_).mapped());
  ++concluded_;
  // Wake the threads only when there is room for many images.
  if (begun_ <= concluded_ + kAhead / 2) changed_.notify_all();
  lock.unlock();
  return vision_.conclude(frames, out);
}

}  // namespace multireach
