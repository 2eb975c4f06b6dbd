#include "vision/stereo_vision.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "vision/association/group_assignment.hpp"
#include "vision/matching/jumps.hpp"
#include "vision/matching/wider_colours.hpp"
#include "vision/reported_covariance.hpp"
#include "vision/shared_state.hpp"

namespace multireach::vision {

namespace {

/// Whether only their motion tells two targets apart.
bool look_alike(const TrackerOptions& a, const TrackerOptions& b) {
  return a.colour == b.colour && a.match.radius_m == b.match.radius_m;
}

}  // namespace

StereoVision::StereoVision(const std::vector<TrackerOptions>& options) {
  if (options.empty()) throw std::invalid_argument("vision needs at least one target");
  std::vector<std::vector<size_t>> groups;
  for (const TrackerOptions& each : options) {
    if (!same_cameras(each.rig, options.front().rig))
      throw std::invalid_argument("all targets of one vision must have the same cameras");
    const auto group = std::ranges::find_if(
        groups, [&](const std::vector<size_t>& other) { return look_alike(options[other.front()], each); });
    if (group == groups.end())
      groups.push_back({targets_.size()});
    else
      group->push_back(targets_.size());
    targets_.push_back({StereoTracker(each)});
  }
  std::ranges::copy_if(groups, std::back_inserter(equal_), [](const auto& group) { return group.size() > 1; });
}

/// The targets that look like this one, itself included; null where there is no other.
const std::vector<size_t>* StereoVision::group_of(size_t target) const {
  const auto group = std::ranges::find_if(
      equal_, [&](const std::vector<size_t>& each) { return std::ranges::find(each, target) != each.end(); });
  return group == equal_.end() ? nullptr : &*group;
}

const char* StereoVision::update(StereoImages& images) {
  const int64_t utime = images.times().pair;
  for (Target& target : targets_) {
    target.views = {};
    target.match = {};
    target.candidates.clear();
    target.found_inside_windows = target.begins_anew = false;
  }
  if (const auto newest = newest_utime(); newest && utime <= *newest) {
    for (Target& target : targets_) target.report = target.tracker.update_unseen(utime, kNotNewer);
    return nullptr;
  }
  const char* fault = measure(images);
  for (size_t k = 0; k < targets_.size(); ++k) {
    Target& target = targets_[k];
    if (!fault && target.begins_anew && target.match.status == StereoMatch::Status::kSeen) target.tracker.lose_track();
    target.report = fault ? target.tracker.update_unseen(utime, fault)
                          : target.tracker.update(images.times(), target.match, target.views[0], target.views[1],
                                                  boxes_of_others(k));
    add_rig_errors(target.tracker.options().rig, target.report);
  }
  return fault;
}

/// What encloses the other targets that look like this one, in both images.
BoxesOfOthers StereoVision::boxes_of_others(size_t target) const {
  BoxesOfOthers boxes;
  const auto* group = group_of(target);
  if (!group) return boxes;
  for (const size_t other : *group) {
    const Target& its = targets_[other];
    using Status = StereoMatch::Status;
    const Status status = its.match.status;
    const bool partly = status == Status::kTogether || status == Status::kOccludedTooMuch ||
                        status == Status::kCutOff || status == Status::kMoreAtBorder;
    if (other == target || !(status == Status::kSeen || partly) || its.match.left < 0 || its.match.right < 0) continue;
    boxes[0].push_back(its.views[0].blobs[static_cast<size_t>(its.match.left)].box);
    boxes[1].push_back(its.views[1].blobs[static_cast<size_t>(its.match.right)].box);
  }
  return boxes;
}

bool StereoVision::both_images_repeat() const {
  const auto dark = [](const Target& target) {
    return std::ranges::any_of(target.views, [](const View& view) { return view.content == View::Content::kDark; });
  };
  return frozen_frames_.both_repeat() && std::ranges::none_of(targets_, dark);
}

void StereoVision::restart() {
  for (Target& target : targets_) target.tracker.restart();
  frozen_frames_ = {};
}

std::optional<int64_t> StereoVision::newest_utime() const {
  const TargetTrack& track = targets_.front().tracker.track();  // all targets take the same pairs
  return track.begun() ? std::optional(track.utime()) : std::nullopt;
}

/// Finds and matches all targets. Returns why the pair as a whole is unusable, or null.
const char* StereoVision::measure(StereoImages& images) {
  for (Target& target : targets_) target.tracker.expire(images.times().pair);
  if (images.times().left < 0) return "there is no left image";
  if (images.times().right < 0) return "there is no right image";
  // Sizes are checked before decoding, so that a wrong or damaged size allocates no memory.
  const StereoTracker& any = targets_.front().tracker;
  for (const Side side : {Side::kLeft, Side::kRight}) {
    if (!images.has(side, any.whole_image(side).size())) return description(StereoMatch::Status::kWrongImageSize);
  }
  frozen_frames_.update({images.fingerprint(Side::kLeft), images.times().left},
                        {images.fingerprint(Side::kRight), images.times().right});
  if (far_apart(images.times())) {
    const auto repeats = frozen_frames_.repeats();
    return repeats ? frozen_frames_.fault() : kFarApartInTime;
  }
  if (!search(images, false)) return "an image cannot be decoded";
  if (!std::ranges::all_of(targets_, &Target::found_inside_windows) && !search(images, true))
    return "an image cannot be decoded";
  refuse_other_things(images.times());
  if (!look_again(images)) return "an image cannot be decoded";
  // A covered camera also repeats a black image; the tracker reports that case as dark.
  const auto black = [&](Side side) {
    return std::ranges::any_of(
        targets_, [&](const Target& target) { return target.views[index(side)].content == View::Content::kDark; });
  };
  if (images.fingerprint(Side::kLeft) == images.fingerprint(Side::kRight) && !black(Side::kLeft))
    return "the left and the right image are the same";
  const auto repeats = frozen_frames_.repeats();
  return repeats && !black(*repeats) ? frozen_frames_.fault() : nullptr;
}

/// Searches both images and matches. Returns false when an image cannot be decoded.
bool StereoVision::search(StereoImages& images, bool everywhere) {
  std::array<bool, 2> decoded{};
  images.for_both_sides([&](Side side) { decoded[index(side)] = search_side(images, side, everywhere); });
  if (!decoded[0] || !decoded[1]) return false;
  for (size_t k = 0; k < targets_.size(); ++k) {
    Target& target = targets_[k];
    if (everywhere && target.found_inside_windows) continue;
    TargetMatch found = target.tracker.match(images.times(), target.views[0], target.views[1],
                                             {.taken = {}, .unknown = group_of(k) != nullptr});
    target.match = found.match;
    target.candidates = std::move(found.candidates);
    target.found_inside_windows =
        target.tracker.is_inside_windows(images.times(), target.match, target.views[0], target.views[1]);
  }
  for (const std::vector<size_t>& group : equal_) GroupAssignment(targets_, group, images.times()).run();
  return true;
}

/// Refuses the matches of targets that one image shows where they are expected: they are other things.
void StereoVision::refuse_other_things(const PairTimes& times) {
  for (size_t k = 0; k < targets_.size(); ++k) {
    Target& target = targets_[k];
    const auto missing =
        seen_in_one_image({target.tracker.options(), target.tracker.object(), times, target.views[0], target.views[1]},
                          target.match, boxes_of_others(k));
    if (!missing) continue;
    target.match.status = *missing;
    for (Candidate& candidate : target.candidates) {
      if (!candidate.chosen) continue;
      candidate.chosen = false;
      candidate.reason = "one image shows the target where it is expected";
    }
  }
}

/// Looks for targets that were not found once more with the wider colour model, where they are expected. Returns false
/// when an image cannot be decoded.
bool StereoVision::look_again(StereoImages& images) {
  for (size_t k = 0; k < targets_.size(); ++k) {
    Target& target = targets_[k];
    if (!target.tracker.may_look_again(images.times().pair, target.match)) continue;
    std::array<View, 2> views;
    for (const Side side : {Side::kLeft, Side::kRight}) {
      const cv::Rect window = *target.tracker.predicted_window(side, images.times().pair);
      const cv::Mat* bgr = images.pixels(side, window);
      if (!bgr) return false;
      views[index(side)] = target.tracker.measure(side, images.times().pair, *bgr, window,
                                                  images.chroma_subsampled(side), Colours::kWider);
    }
    OtherTargets others;
    if (const auto* group = group_of(k)) others = others_of(k, *group, targets_, images.times(), views);
    TargetMatch found = target.tracker.match(images.times(), views[0], views[1], others);
    if (!is_target_again(target.tracker.options(), found, views[0], views[1])) continue;
    if (!target.tracker.is_inside_windows(images.times(), found.match, views[0], views[1])) continue;
    target.match = found.match;
    target.begins_anew = false;
    target.candidates = std::move(found.candidates);
    target.views = std::move(views);
  }
  return true;
}

/// Searches one image for every target: in its window, or, when `everywhere`, in the search area for those not found.
bool StereoVision::search_side(StereoImages& images, Side side, bool everywhere) {
  const auto at = index(side);
  std::vector<cv::Rect> windows;
  cv::Rect part;
  for (const Target& target : targets_) {
    windows.push_back(everywhere ? target.tracker.search_area(side) : target.tracker.window(side, images.times().pair));
    part |= windows.back();
  }
  const cv::Mat* bgr = images.pixels(side, part);
  if (!bgr) return false;
  for (size_t k = 0; k < targets_.size(); ++k) {
    Target& target = targets_[k];
    if (everywhere && target.found_inside_windows) continue;
    if (target.views[at].window != windows[k])
      target.views[at] =
          target.tracker.measure(side, images.times().pair, *bgr, windows[k], images.chroma_subsampled(side));
  }
  return true;
}

std::vector<double> StereoVision::serialize(size_t target, int64_t utime) const {
  return serialize_target(targets_[target], frozen_frames_, utime);
}

bool StereoVision::deserialize(int64_t utime, const std::vector<std::span<const double>>& states) {
  return deserialize_targets(utime, states, targets_, frozen_frames_);
}

}  // namespace multireach::vision
