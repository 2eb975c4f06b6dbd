#include "tools/page/posture_tour.hpp"

namespace multireach {

PostureTour::PostureTour(const RobotConfig& robot, const JointVector& first, uint64_t seed, int measurements)
    : safe_(robot, first, seed), measurements_(measurements) {}

void PostureTour::target(const std::optional<Eigen::Vector3d>& p, const Eigen::Matrix3d& covariance, int64_t now_us,
                         bool arrived) {
  if (!arrived) return;
  if (p) {
    standstills_.target(*p, covariance, now_us);
  } else {
    ++missed_;
  }
}

bool PostureTour::tick(ArmMotion& arm, const std::function<bool(const Eigen::Isometry3d&)>& wanted) {
  constexpr int kMostMissed = 20;
  if (!arm.theta()) return true;
  if (goal_ && !arm.arrived()) return true;
  if (goal_ && standstills_.count() < measurements_ && missed_ < kMostMissed) return true;
  standstills_.end();
  missed_ = 0;
  const auto next = safe_.next(goal_.value_or(*arm.theta()), wanted);
  if (!next) return false;
  goal_ = next;
  ++postures_;
  arm.go_to(*goal_);
  return true;
}

}  // namespace multireach
