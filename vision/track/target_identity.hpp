#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace multireach::vision {

/// How a target of unknown size looks; 0: not known.
struct TargetLook {
  double radius_m = 0;     ///< of a disc of its size
  double compactness = 0;  ///< of the less compact blob, see Appearance
};

/// Whether what is tracked is known to be the target: by its shape, or because it moved to where the image showed
/// nothing of its colour. What only stands there with the right colour may be a part of the scene. And how the target
/// looks, by which it is told from other things when it was hidden.
class TargetIdentity {
 public:
  /// A match that the track accepted.
  struct Observation {
    bool by_contour = false;            ///< both images show a complete sphere contour
    std::array<Eigen::Vector2d, 2> px;  ///< of the left and the right image
    double radius_px = 0;               ///< of the smaller image of it
    TargetLook look{};
    std::array<double, 2> background{0, 0};  ///< share of each blob that the background explains
  };

  /// Takes a match; `elsewhere`: the track begins, or jumps, with it.
  void update(int64_t utime, const Observation& observation, bool elsewhere);
  /// Takes a pair without a match; `lost`: the track has ended.
  void update_unseen(int64_t utime, bool lost);

  /// The camera has moved: what the object seemed to move so far says nothing.
  void restart_motion_evidence();

  /// The tracked object is the target.
  bool confirmed() const { return confirmed_; }
  /// The tracked object never moved by more than a part of its size.
  bool stands_still() const { return !strayed_; }
  /// The target was confirmed at least once, and not too long ago to be sure that nothing else is meant.
  bool known() const { return known_; }
  /// The target is known, and was not lost since it was confirmed last; a jump does not change this. Until then it is
  /// arbitrary which of several targets that look alike follows which object.
  bool established() const { return known_ && !lost_since_; }
  /// About how the target looked while it was confirmed, and not in doubt after it was found again; zeros unless it is
  /// known.
  const TargetLook& look() const { return look_; }
  /// Whether the track began, or jumped, so shortly before that the tracked object may be another thing, though it may
  /// be confirmed: a shorter time before than that for which the target is known.
  bool doubtful(int64_t utime) const { return utime - began_utime_ < kForgets; }
  /// Where the target was seen last, in pixels; radius 0 before the first match or when that was too long ago.
  Eigen::Vector2d last_px(size_t side) const { return last_px_[side]; }
  double last_radius_px() const { return last_radius_px_; }
  /// Time of the last match, microseconds.
  int64_t last_utime() const { return last_utime_; }

  static constexpr size_t kSerializedSize = 19;
  /// The complete state; times are relative to `utime`.
  std::vector<double> serialize(int64_t utime) const;
  /// Restores a state of serialize(utime). Returns false, and changes nothing, when `state` is not valid.
  [[nodiscard]] bool deserialize(int64_t utime, std::span<const double> state);

 private:
  static constexpr int64_t kForgets = 10000000;  // us without a match, after which the target is no longer known

  bool confirmed_ = false, known_ = false, strayed_ = false;
  bool lost_since_ = false;       // known, but lost since it was confirmed last
  bool found_again_ = false;      // the target was known when the track began
  int contours_ = 0, moved_ = 0;  // matches that speak for the target
  std::array<Eigen::Vector2d, 2> first_px_{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  std::array<Eigen::Vector2d, 2> last_px_{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  TargetLook look_;
  double last_radius_px_ = 0;
  int64_t last_utime_ = 0, began_utime_ = 0;  // of the last match, and of that with which the track began
};

}  // namespace multireach::vision
