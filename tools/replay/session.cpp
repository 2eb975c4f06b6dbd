#include "tools/replay/session.hpp"

#include <algorithm>

#include "runtime/channels.hpp"
#include "runtime/files.hpp"
#include "runtime/message_walk.hpp"
#include "runtime/node.hpp"

namespace multireach {
namespace {

constexpr int64_t kMaxCameraJump = 1000000;  // us; a larger jump of the camera's time means another clock
constexpr int64_t kMaxPause = 3600000000;    // us
constexpr int64_t kReadAhead = 1000000;      // us

/// The time that images_t and target_t carry in their first field, after the fingerprint.
std::optional<int64_t> camera_time(const LogEvent& event) {
  const bool timed = event.channel == channel::kStereoImages || event.channel == channel::kTarget ||
                     event.channel == channel::kTargetTruth;
  if (!timed) return std::nullopt;
  if (event.data.size() < 16) return std::nullopt;
  const auto utime = big_endian<int64_t>(event.data.subspan(8));
  if (!plausible_utime(utime)) return std::nullopt;
  return utime;
}

/// Whether `second` was received before `duration_us` had passed since `first`. Damaged times can have any value.
bool received_within(int64_t duration_us, const LogEvent& first, const LogEvent& second) {
  return second.utime <= first.utime ||
         static_cast<uint64_t>(second.utime) - static_cast<uint64_t>(first.utime) < static_cast<uint64_t>(duration_us);
}

}  // namespace

Session::Session(const std::string& path, ReplayFrom from, bool with_robot_states) : log_(path) {
  channels_ = {channel::kObstacles, channel::kPerturbation};
  if (from == ReplayFrom::kImages) {
    channels_.insert(channels_.end(), {channel::kStereoImages, channel::kTargetTruth});
  } else {
    channels_.insert(channels_.end(), {channel::kTarget, channel::kTargetChoice, channel::kTargetTruth});
  }
  if (with_robot_states) channels_.push_back(channel::kRobotState);
  while (const auto event = log_.next()) {
    if (!wanted(event->channel)) continue;
    if (plausible_utime(event->utime)) recorded_utime_ = event->utime;
    break;
  }
  rewind();
}

bool Session::wanted(std::string_view channel) const {
  return std::ranges::find(channels_, channel) != channels_.end();
}

void Session::rewind() {
  log_.rewind();
  waiting_.clear();
  now_us_ = 0;
  event_utime_.reset();
  camera_utime_.reset();
  camera_at_.reset();
}

int64_t Session::time_since_previous(const LogEvent& event) const {
  // A damaged time stamp can have any value.
  if (!event_utime_ || event.utime <= *event_utime_) return 0;
  const uint64_t pause = static_cast<uint64_t>(event.utime) - static_cast<uint64_t>(*event_utime_);
  return static_cast<int64_t>(std::min<uint64_t>(pause, kMaxPause));
}

int64_t Session::time_of(const LogEvent& event, int64_t camera_utime) const {
  const bool follows =
      camera_utime_ && camera_utime >= *camera_utime_ && camera_utime - *camera_utime_ <= kMaxCameraJump;
  return follows ? std::max(now_us_, *camera_at_ + camera_utime - *camera_utime_)
                 : now_us_ + time_since_previous(event);
}

bool Session::read_ahead() {
  while (waiting_.empty() ||
         (!camera_time(waiting_.back()) && received_within(kReadAhead, waiting_.front(), waiting_.back()))) {
    auto event = log_.next();
    while (event && !wanted(event->channel)) event = log_.next();
    if (!event) break;
    waiting_.push_back(*event);
  }
  return !waiting_.empty();
}

std::optional<SessionInput> Session::next() {
  if (!read_ahead()) return std::nullopt;
  const LogEvent event = waiting_.front();
  if (const auto utime = camera_time(event)) {
    now_us_ = time_of(event, *utime);
    camera_utime_ = utime;
    camera_at_ = now_us_;
  } else {
    const int64_t at = now_us_ + time_since_previous(event);
    // Jitter of the recorder's clock must not delay the following image.
    const auto next_image = camera_time(waiting_.back());
    now_us_ = next_image ? std::min(at, time_of(waiting_.back(), *next_image)) : at;
  }
  event_utime_ = event.utime;
  waiting_.pop_front();
  return SessionInput{now_us_, event.channel, event.data};
}

ReplayFrom replay_source(const std::string& path) {
  LogReader log(path);
  bool targets = false;
  while (const auto event = log.next()) {
    if (event->channel == channel::kStereoImages) return ReplayFrom::kImages;
    targets = targets || event->channel == channel::kTarget;
  }
  if (!targets) throw InputError(path + ": has neither STEREO_IMAGES nor TARGET: there is nothing to replay");
  return ReplayFrom::kTargets;
}

}  // namespace multireach
