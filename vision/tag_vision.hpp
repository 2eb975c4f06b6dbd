#pragma once

#include <vector>

#include "vision/stereo_vision.hpp"
#include "vision/tag_tracker.hpp"

namespace multireach::vision {

/// Vision as a stage, for tags: tracks one or more AprilTags through stereo pairs. It searches each image around the
/// predicted positions first, and the whole image for those tags that were not found there. Deterministic.
class TagVision {
 public:
  /// What the last pair shows of one tag.
  struct Target {
    TagTracker tracker;
    std::array<TagView, 2> views{};
    TagMatch match{};
    TagReport report{};
  };

  /// All options must have the same rig. Throws std::invalid_argument for invalid ones.
  explicit TagVision(const std::vector<TagOptions>& options);

  void restart();
  /// Time of the newest pair since the start, microseconds.
  std::optional<int64_t> newest_utime() const;
  /// Takes the next pair, in which one image may be missing. Returns null, or why the pair as a whole is unusable.
  const char* update(StereoImages& images);
  const std::vector<Target>& targets() const { return targets_; }
  /// Whether both cameras send the same images again and again: see FrozenFrameDetector::both_repeat().
  bool both_images_repeat() const { return frozen_frames_.both_repeat(); }

  /// The state of one tag, and of what all tags share, after a pair at time `utime` (microseconds).
  std::vector<double> serialize(size_t target, int64_t utime) const;
  /// Restores the states that serialize(k, utime) returned for all tags. Returns false, and changes nothing, when one
  /// is not valid.
  [[nodiscard]] bool deserialize(int64_t utime, const std::vector<std::span<const double>>& states);

 private:
  const char* measure(StereoImages& images);
  bool search(StereoImages& images, bool everywhere);
  bool search_side(StereoImages& images, Side side, bool everywhere);

  std::vector<Target> targets_;
  std::array<TagDetector, 2> detectors_;
  FrozenFrameDetector frozen_frames_;
};

}  // namespace multireach::vision
