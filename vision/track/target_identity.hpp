#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace multireach::vision {

/// Whether what is tracked is known to be the target: by its shape, or because it moved to where the image showed
/// nothing of its colour. What only stands there with the right colour may be a part of the scene.
class TargetIdentity {
 public:
  /// A match that the track accepted.
  struct Observation {
    bool by_contour = false;                 ///< both images show a complete sphere contour
    std::array<Eigen::Vector2d, 2> px;       ///< of the left and the right image
    double radius_px = 0;                    ///< of the smaller image of it
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
  /// Where the target was seen last, in pixels; radius 0 before the first match or when that was too long ago.
  Eigen::Vector2d last_px(size_t side) const { return last_px_[side]; }
  double last_radius_px() const { return last_radius_px_; }
  /// Time of the last match, microseconds.
  int64_t last_utime() const { return last_utime_; }

  static constexpr size_t kSerializedSize = 15;
  /// The complete state; times are relative to `utime`.
  std::vector<double> serialize(int64_t utime) const;
  /// Restores a state of serialize(utime). Returns false, and changes nothing, when `state` is not valid.
  [[nodiscard]] bool deserialize(int64_t utime, std::span<const double> state);

 private:
  bool confirmed_ = false, known_ = false, strayed_ = false;
  bool lost_since_ = false;       // known, but lost since it was confirmed last
  int contours_ = 0, moved_ = 0;  // matches that speak for the target
  std::array<Eigen::Vector2d, 2> first_px_{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  std::array<Eigen::Vector2d, 2> last_px_{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  double last_radius_px_ = 0;
  int64_t last_utime_ = 0;  // of the last match
};

}  // namespace multireach::vision
