#pragma once

#include <functional>
#include <vector>

#include "vision/camera_check/frozen_frame_detector.hpp"
#include "vision/stereo_tracker.hpp"

namespace multireach::vision {

/// The two images of a pair, decoded on demand, because decoding takes longer than everything else.
class StereoImages {
 public:
  virtual ~StereoImages() = default;
  /// Capture times, microseconds; that of an image is negative when the pair lacks it.
  virtual PairTimes times() const = 0;
  /// Whether the pair has this image, of this size (pixels). The image may still be damaged.
  virtual bool has(Side side, const cv::Size& size) const = 0;
  /// A hash of the image's bytes, below 2^53.
  virtual int64_t fingerprint(Side side) const = 0;
  /// The image as 8-bit BGR, valid at least in `part`; null when it cannot be decoded there. Both sides may be
  /// requested concurrently. The pixels must live until update() returns.
  virtual const cv::Mat* pixels(Side side, const cv::Rect& part) = 0;
  /// Whether the image is known to have been encoded with chroma of a lower resolution than its luma.
  virtual bool chroma_subsampled(Side) const { return false; }
  /// Calls `work` for both sides, in this thread or concurrently.
  virtual void for_both_sides(const std::function<void(Side)>& work) {
    work(Side::kLeft);
    work(Side::kRight);
  }
};

/// A pair of images that are decoded already, 8-bit BGR.
class DecodedImages final : public StereoImages {
 public:
  DecodedImages(const PairTimes& times, const cv::Mat& left, const cv::Mat& right, bool chroma_subsampled = false)
      : times_(times),
        bgr_{left, right},
        same_(!left.empty() && left.size() == right.size() && left.type() == right.type() &&
              cv::norm(left, right, cv::NORM_INF) == 0),
        chroma_subsampled_(chroma_subsampled) {}
  PairTimes times() const override { return times_; }
  bool has(Side side, const cv::Size& size) const override { return image(side).size() == size; }
  /// Tells only whether the two images are the same; the images of all pairs count as repeated, and so no camera as
  /// frozen.
  int64_t fingerprint(Side side) const override { return same_ ? 3 : side == Side::kLeft ? 1 : 2; }
  const cv::Mat* pixels(Side side, const cv::Rect&) override { return &image(side); }
  bool chroma_subsampled(Side) const override { return chroma_subsampled_; }

 private:
  const cv::Mat& image(Side side) const { return bgr_[index(side)]; }

  PairTimes times_;
  std::array<cv::Mat, 2> bgr_;
  bool same_, chroma_subsampled_;
};

/// Vision as a stage: tracks one or more coloured objects through stereo pairs. It searches each image around the
/// predicted positions first, and the whole search area for those targets that were not found there. Of targets that
/// look alike (the same colours and radius), no two are the same thing: what is seen is assigned to them by their
/// motion, and those that are not tracked take what remains, in the order of their options. Deterministic.
class StereoVision {
 public:
  /// What the last pair shows of one target.
  struct Target {
    StereoTracker tracker;
    std::array<View, 2> views{};
    StereoMatch match{};
    std::vector<Candidate> candidates{};  ///< what `match` was chosen from, best first
    TargetReport report{};
    bool found_inside_windows = false;  ///< found, and completely inside the search windows
    bool begins_anew = false;           ///< `match` is no part of the track, which ends
  };

  /// One set of options for each target; all must have the same rig. Throws std::invalid_argument for no target and
  /// for invalid options.
  explicit StereoVision(const std::vector<TrackerOptions>& options);

  /// Forgets all pairs. Call it when time starts again; pairs that are not newer than the newest one are rejected.
  void restart();
  /// Time of the newest pair since the start, microseconds.
  std::optional<int64_t> newest_utime() const;
  /// Takes the next pair. Returns null, or why the pair as a whole is unusable; the targets then coast.
  const char* update(StereoImages& images);
  /// The targets after the last pair, in the order of their options.
  const std::vector<Target>& targets() const { return targets_; }
  /// Whether both cameras send the same images again and again, none of them black: see
  /// FrozenFrameDetector::both_repeat().
  bool both_images_repeat() const;

  /// The state of one target, and of what all targets share, after a pair at time `utime` (microseconds).
  std::vector<double> serialize(size_t target, int64_t utime) const;
  /// Restores the states that serialize(k, utime) returned for all targets. Returns false, and changes nothing, when
  /// one is not valid.
  [[nodiscard]] bool deserialize(int64_t utime, const std::vector<std::span<const double>>& states);

 private:
  const char* measure(StereoImages& images);
  bool search(StereoImages& images, bool everywhere);
  void refuse_other_things(const PairTimes& times);
  bool look_again(StereoImages& images);
  bool search_side(StereoImages& images, Side side, bool everywhere);
  const std::vector<size_t>* group_of(size_t target) const;
  BoxesOfOthers boxes_of_others(size_t target) const;

  std::vector<Target> targets_;
  std::vector<std::vector<size_t>> equal_;  // groups of targets that look alike, by their indices
  FrozenFrameDetector frozen_frames_;
};

}  // namespace multireach::vision
