#include "camera/pairing/stereo_buffer.hpp"

#include <fmt/format.h>

#include <chrono>
#include <stdexcept>

namespace multireach {
namespace {

constexpr int64_t kLongWithoutPair = 1000000;  // us; plus two frame periods
constexpr size_t kMaxQueue = 8;                // pairs waiting to be sent; beyond that, the oldest is dropped

}  // namespace

void StereoBuffer::push(Side side, Frame frame) {
  const std::lock_guard lock(mutex_);
  if (!first_frame_) first_frame_ = frame.utime;
  for (FramePairing::Pair& pair : pairing_.add(side, std::move(frame))) {
    newest_pair_ = pair.left.utime;
    skew_.add(pair.left.utime, pair.right.utime - pair.left.utime);
    pairs_.push_back(std::move(pair));
    if (pairs_.size() <= kMaxQueue) continue;
    pairs_.pop_front();
    ++unsent_;
  }
  changed_.notify_all();
}

bool StereoBuffer::has_room(Side side) const {
  const Side other = side == Side::kLeft ? Side::kRight : Side::kLeft;
  const bool partner_comes = !ended_[index(other)] && fault_[index(other)].empty();
  return (pairing_.waiting(side) < FramePairing::kMaxQueue || !partner_comes) && pairs_.size() < kMaxQueue;
}

bool StereoBuffer::wait_for_room(Side side, int64_t timeout_us) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::chrono::microseconds(timeout_us), [&] { return has_room(side); });
}

void StereoBuffer::set_fault(Side side, std::string fault) {
  const std::lock_guard lock(mutex_);
  fault_[index(side)] = std::move(fault);
  changed_.notify_all();
}

void StereoBuffer::reset(Side side) {
  const std::lock_guard lock(mutex_);
  pairing_.reset(side);
}

void StereoBuffer::end(Side side) {
  const std::lock_guard lock(mutex_);
  ended_[index(side)] = true;
  changed_.notify_all();
}

void StereoBuffer::fail(std::string sentence) {
  const std::lock_guard lock(mutex_);
  failure_ = std::move(sentence);
  changed_.notify_all();
}

std::optional<FramePairing::Pair> StereoBuffer::pop(int64_t timeout_us) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::microseconds(timeout_us),
                    [&] { return !pairs_.empty() || !failure_.empty() || finished(); });
  if (pairs_.empty() && !failure_.empty()) throw std::runtime_error(failure_);
  if (pairs_.empty()) return std::nullopt;
  FramePairing::Pair pair = std::move(pairs_.front());
  pairs_.pop_front();
  changed_.notify_all();
  return pair;
}

bool StereoBuffer::finished() const {
  const auto finished_for = [this](Side side) { return ended_[index(side)] && pairing_.waiting(side) == 0; };
  return finished_for(Side::kLeft) || finished_for(Side::kRight) || (ended_[0] && ended_[1]);
}

bool StereoBuffer::ended() const {
  const std::lock_guard lock(mutex_);
  return pairs_.empty() && finished();
}

std::string StereoBuffer::state(int64_t utime) const {
  const std::lock_guard lock(mutex_);
  if (!fault_[0].empty() || !fault_[1].empty()) {
    return fault_[0] + (fault_[0].empty() || fault_[1].empty() ? "" : "; ") + fault_[1];
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
