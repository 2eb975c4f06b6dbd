#include "camera/pairing/stereo_buffer.hpp"

#include <fmt/format.h>

#include <chrono>

namespace multireach {
namespace {

constexpr int64_t kLongWithoutPair = 1000000;  // us; plus two frame periods
constexpr size_t kDeepest = 8;                 // pairs waiting to be sent; beyond that, the oldest is dropped

}  // namespace

void StereoBuffer::put(Side side, Frame frame) {
  const std::lock_guard lock(mutex_);
  if (!first_frame_) first_frame_ = frame.utime;
  for (FramePairing::Pair& pair : pairing_.add(side, std::move(frame))) {
    newest_pair_ = pair.left.utime;
    skew_.add(pair.left.utime, pair.right.utime - pair.left.utime);
    pairs_.push_back(std::move(pair));
    if (pairs_.size() <= kDeepest) continue;
    pairs_.pop_front();
    ++unsent_;
  }
  changed_.notify_all();
}

bool StereoBuffer::room(Side side) const {
  const Side other = side == Side::kLeft ? Side::kRight : Side::kLeft;
  const bool partner_comes = !ended_[static_cast<size_t>(other)] && trouble_[static_cast<size_t>(other)].empty();
  return (pairing_.waiting(side) < FramePairing::kDeepest || !partner_comes) && pairs_.size() < kDeepest;
}

bool StereoBuffer::wait_for_room(Side side, int64_t timeout_us) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::chrono::microseconds(timeout_us), [&] { return room(side); });
}

void StereoBuffer::set_trouble(Side side, std::string trouble) {
  const std::lock_guard lock(mutex_);
  trouble_[static_cast<size_t>(side)] = std::move(trouble);
  changed_.notify_all();
}

void StereoBuffer::forget(Side side) {
  const std::lock_guard lock(mutex_);
  pairing_.forget(side);
}

void StereoBuffer::end(Side side) {
  const std::lock_guard lock(mutex_);
  ended_[static_cast<size_t>(side)] = true;
  changed_.notify_all();
}

std::optional<FramePairing::Pair> StereoBuffer::take(int64_t timeout_us) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::microseconds(timeout_us), [&] { return !pairs_.empty() || over(); });
  if (pairs_.empty()) return std::nullopt;
  FramePairing::Pair pair = std::move(pairs_.front());
  pairs_.pop_front();
  changed_.notify_all();
  return pair;
}

bool StereoBuffer::over() const {
  const auto over_for = [this](Side side) { return ended_[static_cast<size_t>(side)] && pairing_.waiting(side) == 0; };
  return over_for(Side::kLeft) || over_for(Side::kRight) || (ended_[0] && ended_[1]);
}

bool StereoBuffer::ended() const {
  const std::lock_guard lock(mutex_);
  return pairs_.empty() && over();
}

std::string StereoBuffer::state(int64_t utime) const {
  const std::lock_guard lock(mutex_);
  if (!trouble_[0].empty() || !trouble_[1].empty()) {
    return trouble_[0] + (trouble_[0].empty() || trouble_[1].empty() ? "" : "; ") + trouble_[1];
  }
  if (!first_frame_) return "waiting for the first images";
  const int64_t since = newest_pair_.value_or(*first_frame_);
  if (utime - since > kLongWithoutPair + 2 * pairing_.period_us()) {
    return fmt::format("no pair for {:.0f} s: left and right are more than {:.1f} ms apart, {} unpaired",
                       1e-6 * static_cast<double>(utime - since), 1e-3 * static_cast<double>(pairing_.max_skew_us()),
                       pairing_.unpaired());
  }
  const auto skew = skew_.last_second();
  if (!skew) return "waiting for the first pair";
  const std::string unsent = unsent_ > 0 ? fmt::format(", {} pairs not sent", unsent_) : "";
  return fmt::format("running, skew {:.1f} ms, max {:.1f}, {} unpaired{}", 1e-3 * static_cast<double>(skew->median_us),
                     1e-3 * static_cast<double>(skew->max_us), pairing_.unpaired(), unsent);
}

}  // namespace multireach
