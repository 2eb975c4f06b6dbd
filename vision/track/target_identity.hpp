#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "vision/track/target_track.hpp"

namespace multireach::vision {

/// What a target of unknown size looks like; 0: not known.
struct TargetAppearance {
  double radius_m = 0;     ///< of a sphere of its size in the left image
  double compactness = 0;  ///< of the less compact blob, see Appearance
};

/// Whether what is tracked is known to be the target: by its shape, unless its colour has been there for long, or
/// because it moved to where the image showed nothing of its colour. What only stands there with the right colour may
/// be a part of the scene. And what the target looks like, by which it is told from other objects after it was
/// occluded.
class TargetIdentity {
 public:
  /// A match that the track accepted.
  struct Observation {
    bool by_contour = false;                 ///< both images show a sphere's contour
    bool of_known_size = false;              ///< the target's radius is known, and the match has it
    bool convincing = false;                 ///< see is_convincing()
    std::array<Eigen::Vector2d, 2> px;       ///< of the left and the right image
    double radius_px = 0;                    ///< of the smaller image of it
    TargetAppearance appearance{};           ///< zeros: this match does not tell
    std::array<double, 2> background{0, 0};  ///< share of each blob that the background explains
  };

  /// Takes a match, with which a motion may start. After a first match or a jump, it may be another object. A jump that
  /// was accepted at once is a bounce: the object is the same, but its position tells nothing about its motion.
  void update(int64_t utime, const Observation& observation, TargetTrack::Start start);
  /// Takes a pair without a match; `lost`: the track has ended.
  void update_unseen(int64_t utime, bool lost);

  /// The camera has moved: what the object seemed to move so far says nothing.
  void restart_motion_evidence();

  /// The tracked object is the target.
  bool confirmed() const { return confirmation_ == Confirmation::kNow; }
  /// The tracked object never moved by more than a part of its size.
  bool stands_still() const { return !has_moved_; }
  /// The target was confirmed at least once, and not too long ago to be sure that nothing else is meant.
  bool known() const { return confirmation_ != Confirmation::kNever; }
  /// The target is known, and was not lost since it was confirmed last; a jump does not change this. Until then it is
  /// arbitrary which of several targets that look alike follows which object.
  bool established() const { return confirmation_ >= Confirmation::kBeforeJump; }
  /// What the confirmed target looked like, smoothed; zeros where no match told it, or showed a sphere's contour, for
  /// ten seconds. It is not learned while a target that was found again may be another thing.
  TargetAppearance appearance(int64_t utime) const;
  /// Whether the tracked thing may be another one, even if it is confirmed: the track began or jumped less than ten
  /// seconds ago, and either the target was known before, or no match since then was convincing.
  bool doubtful(int64_t utime) const { return (found_again_ || !convincing_) && utime - began_utime_ < kForgets; }
  /// Whether the target was known when the track began or jumped.
  bool found_again() const { return found_again_; }
  /// Where the target was seen last, in pixels; radius 0 before the first match or when that was too long ago.
  Eigen::Vector2d last_px(size_t side) const { return last_px_[side]; }
  double last_radius_px() const { return last_radius_px_; }
  /// Time of the last match, microseconds.
  int64_t last_utime() const { return last_utime_; }

  static constexpr size_t kSerializedSize = 20;
  /// The complete state; times are relative to `utime`.
  std::vector<double> serialize(int64_t utime) const;
  /// Restores a state of serialize(utime). Returns false, and changes nothing, when `state` is not valid.
  [[nodiscard]] bool deserialize(int64_t utime, std::span<const double> state);

 private:
  static constexpr int64_t kForgets = 10000000;  // us without a match, after which the target is no longer known

  /// When the target was confirmed last: never, or so long ago that it does not count; before it was lost, or jumped;
  /// or it still is.
  enum class Confirmation { kNever, kBeforeLoss, kBeforeJump, kNow };
  Confirmation confirmation_ = Confirmation::kNever;
  bool has_moved_ = false;
  bool found_again_ = false;      // the target was known when the track began or jumped
  bool convincing_ = false;       // a match since then was
  int contours_ = 0, moved_ = 0;  // matches that speak for the target
  std::array<Eigen::Vector2d, 2> first_px_{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  std::array<Eigen::Vector2d, 2> last_px_{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  TargetAppearance appearance_;
  double last_radius_px_ = 0;
  // Of the last match, of that with which the track began or jumped, and of the last one that told the appearance or
  // showed a contour.
  int64_t last_utime_ = 0, began_utime_ = 0, appearance_utime_ = 0;
};

}  // namespace multireach::vision
