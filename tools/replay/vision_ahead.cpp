#include "tools/replay/vision_ahead.hpp"

#include "runtime/channels.hpp"

namespace multireach {
namespace {

constexpr int64_t kAhead = 64;  // messages

}  // namespace

VisionAhead::VisionAhead(const ReplayOptions& options)
    : vision_(*options.vision), session_(options.session, options.from, false) {
  for (int i = 0; i < options.threads; ++i) {
    threads_.emplace_back([this, config = *options.vision] {
      try {
        work(config);
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

void VisionAhead::work(const VisionConfig& config) {
  Eyes eyes(config, 1);
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stop_ || begun_ < concluded_ + kAhead; });
    auto input = session_.next();
    while (input && input->channel != channel::kStereoImages) input = session_.next();
    if (!input || stop_) return;
    const int64_t index = begun_++;
    lock.unlock();
    Glimpse glimpse = eyes.look(input->data);
    lock.lock();
    glimpses_.emplace(index, std::move(glimpse));
    if (index == concluded_) changed_.notify_all();
  }
}

Receipt VisionAhead::receive(std::string_view, std::span<const uint8_t>, Outbox& out) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return glimpses_.contains(concluded_) || failure_; });
  if (!glimpses_.contains(concluded_)) std::rethrow_exception(failure_);
  const Glimpse glimpse = std::move(glimpses_.extract(concluded_).mapped());
  ++concluded_;
  // The threads are woken when there is room for many.
  if (begun_ <= concluded_ + kAhead / 2) changed_.notify_all();
  lock.unlock();
  return vision_.conclude(glimpse, out);
}

}  // namespace multireach
