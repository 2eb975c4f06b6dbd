#pragma once

#include <optional>

#include "tools/calibrate/hand_eye_samples.hpp"
#include "tools/page/arm_motion.hpp"
#include "tools/page/safe_postures.hpp"

namespace multireach {

/// Takes a hand that holds the target from one safe posture to the next, and collects where the target is seen while
/// the hand stands still. A posture at which the target is not seen gives nothing.
class PostureTour {
 public:
  /// `measurements`: of the target at each posture.
  PostureTour(const RobotConfig& robot, const JointVector& first, uint64_t seed, int measurements = 8);

  void hand(const Eigen::Isometry3d& X_WH, int64_t now_us) { standstills_.hand(X_WH, now_us); }
  /// The target was seen at `p` (in any frame, always the same), or, with nothing, not.
  void target(const std::optional<Eigen::Vector3d>& p, const Eigen::Matrix3d& covariance, int64_t now_us, bool arrived);
  /// Moves the arm on when the current posture is done. `wanted`: see SafePostures. Returns false when no posture is
  /// left.
  bool tick(ArmMotion& arm, const std::function<bool(const Eigen::Isometry3d&)>& wanted);

  const std::vector<HandEyeSample>& samples() const { return standstills_.samples(); }
  int postures() const { return postures_; }
  const std::optional<JointVector>& goal() const { return goal_; }

 private:
  SafePostures safe_;
  Standstills standstills_{0.002};
  std::optional<JointVector> goal_;
  int measurements_, postures_ = 0, missed_ = 0;
};

}  // namespace multireach
