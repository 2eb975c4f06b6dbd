#include "tools/page/outgoing_queue.hpp"

#include <algorithm>
#include <utility>

namespace multireach {

void OutgoingQueue::push(Outgoing outgoing) {
  const std::lock_guard lock(mutex_);
  switch (outgoing.kind) {
    case Outgoing::Kind::kAnswer:
      if (answers_.size() >= kMaxAnswers) answers_.pop_front();
      answers_.push_back(std::move(outgoing));
      break;
    case Outgoing::Kind::kFrame:
      if (frames_.size() >= kMaxFrames) {
        frames_.pop_front();
        dropped_ = true;
      }
      frames_.push_back(std::move(outgoing));
      break;
    default: {
      const auto picture = static_cast<size_t>(outgoing.kind) - static_cast<size_t>(Outgoing::Kind::kLeftPicture);
      pictures_[picture] = std::move(outgoing);
    }
  }
  changed_.notify_one();
}

bool OutgoingQueue::empty() const {
  return answers_.empty() && frames_.empty() && std::ranges::none_of(pictures_, [](const auto& p) { return !!p; });
}

std::optional<Outgoing> OutgoingQueue::pop() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return closed_ || !empty(); });
  if (closed_) return std::nullopt;
  for (std::deque<Outgoing>* queue : {&answers_, &frames_}) {
    if (queue->empty()) continue;
    Outgoing next = std::move(queue->front());
    queue->pop_front();
    return next;
  }
  for (auto& picture : pictures_) {
    if (picture) return std::exchange(picture, std::nullopt);
  }
  return std::nullopt;
}

void OutgoingQueue::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

bool OutgoingQueue::take_dropped() {
  const std::lock_guard lock(mutex_);
  // While frames still wait, another complete one would only be dropped, too.
  return frames_.empty() && std::exchange(dropped_, false);
}

}  // namespace multireach
