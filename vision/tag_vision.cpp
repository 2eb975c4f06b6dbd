#include "vision/tag_vision.hpp"

#include <algorithm>

#include "vision/reported_covariance.hpp"
#include "vision/shared_state.hpp"

namespace multireach::vision {
namespace {

constexpr std::array kSides{Side::kLeft, Side::kRight};

/// Whether the search windows sufficed: the tag was measured in both images.
bool found_in_both(const TagVision::Target& target) {
  return target.match.pose && target.match.used[0] && target.match.used[1];
}

}  // namespace

TagVision::TagVision(const std::vector<TagOptions>& options) {
  for (const TagOptions& each : options) {
    if (!same_cameras(each.rig, options.front().rig))
      throw std::invalid_argument("all tags of one vision must have the same cameras");
    targets_.push_back({TagTracker(each)});
  }
}

void TagVision::restart() {
  for (Target& target : targets_) target.tracker.restart();
  frozen_frames_ = {};
}

std::optional<int64_t> TagVision::newest_utime() const {
  if (targets_.empty()) return std::nullopt;
  const TargetTrack& track = targets_.front().tracker.track();  // all take the same pairs
  return track.begun() ? std::optional(track.utime()) : std::nullopt;
}

const char* TagVision::update(StereoImages& images) {
  if (targets_.empty()) return nullptr;
  const int64_t utime = images.times().pair;
  for (Target& target : targets_) {
    target.views = {};
    target.match = {};
  }
  if (utime <= newest_utime().value_or(utime - 1)) {
    for (Target& target : targets_) target.report = target.tracker.update_unseen(utime, kNotNewer);
    return nullptr;
  }
  const char* fault = measure(images);
  for (Target& target : targets_) {
    target.report =
        fault ? target.tracker.update_unseen(utime, fault) : target.tracker.update(images.times(), target.match);
    add_rig_errors(target.tracker.options().rig, target.match.used, target.report);
  }
  return fault;
}

/// Finds all tags. Returns why the pair as a whole is unusable, or null.
const char* TagVision::measure(StereoImages& images) {
  for (Target& target : targets_) target.tracker.expire(images.times().pair);
  const PairTimes times = images.times();
  if (times.left < 0 && times.right < 0) return "there is neither a left nor a right image";
  for (const Side side : kSides) {
    const bool there = (side == Side::kLeft ? times.left : times.right) >= 0;
    // Checked before decoding, so that a wrong or damaged size allocates no memory.
    if (there && !images.has(side, targets_.front().tracker.whole_image(side).size()))
      return description(StereoMatch::Status::kWrongImageSize);
  }
  const bool both = times.left >= 0 && times.right >= 0;
  if (both)
    frozen_frames_.update({images.fingerprint(Side::kLeft), times.left},
                          {images.fingerprint(Side::kRight), times.right});
  if (far_apart(times)) {
    const char* fault = both ? frozen_frames_.fault() : nullptr;
    return fault ? fault : kFarApartInTime;
  }
  if (!search(images, false)) return "an image cannot be decoded";
  if (!std::ranges::all_of(targets_, found_in_both) && !search(images, true)) return "an image cannot be decoded";
  return both ? frozen_frames_.fault() : nullptr;
}

/// Searches both images and estimates the poses. Returns false when an image cannot be decoded.
bool TagVision::search(StereoImages& images, bool everywhere) {
  std::array<bool, 2> decoded{};
  images.for_both_sides([&](Side side) { decoded[index(side)] = search_side(images, side, everywhere); });
  if (!decoded[0] || !decoded[1]) return false;
  for (Target& target : targets_) {
    if (!(everywhere && found_in_both(target))) target.match = target.tracker.match(images.times(), target.views);
  }
  return true;
}

/// Searches one image, where there is one, for every tag: in its window, or, when `everywhere`, in the whole image for
/// those not found in both images.
bool TagVision::search_side(StereoImages& images, Side side, bool everywhere) {
  const PairTimes times = images.times();
  if ((side == Side::kLeft ? times.left : times.right) < 0) return true;
  std::vector<Target*> searching;
  cv::Rect part;
  for (Target& target : targets_) {
    if (everywhere && found_in_both(target)) continue;
    TagView& view = target.views[index(side)];
    const cv::Rect window = everywhere ? target.tracker.whole_image(side) : target.tracker.window(side, times.pair);
    if (view.searched && view.window == window) continue;
    view = {.window = window, .bgr = {}, .searched = true, .others = false, .matches = {}};
    part |= window;
    searching.push_back(&target);
  }
  if (searching.empty()) return true;
  const cv::Mat* bgr = images.pixels(side, part);
  if (!bgr) return false;
  const std::vector<FoundTag> found = detectors_[index(side)].find(*bgr, part);
  for (Target* target : searching) {
    TagView& view = target->views[index(side)];
    view.window = part;
    view.bgr = *bgr;
    for (const FoundTag& tag : found) {
      if (tag.id == target->tracker.options().id) {
        view.matches.push_back(tag);
      } else {
        view.others = true;
      }
    }
  }
  return true;
}

std::vector<double> TagVision::serialize(size_t target, int64_t utime) const {
  return serialize_target(targets_[target], frozen_frames_, utime);
}

bool TagVision::deserialize(int64_t utime, const std::vector<std::span<const double>>& states) {
  return deserialize_targets(utime, states, targets_, frozen_frames_);
}

}  // namespace multireach::vision
