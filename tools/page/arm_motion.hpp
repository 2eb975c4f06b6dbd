#pragma once

#include <multireach/bridge_state_t.hpp>
#include <optional>
#include <string>

#include "kinematics/chain.hpp"
#include "runtime/node.hpp"

namespace multireach {

/// Moves the arm slowly to joint configurations, in place of the controller, which must send no set-points meanwhile:
/// sends JOINT_SETPOINT along the straight line of joint space. The bridge keeps all limits and obeys enable, pause and
/// stop. Knows time only from its arguments, microseconds.
class ArmMotion {
 public:
  static constexpr double kShareOfLimit = 0.25;  ///< of each joint's speed limit
  static constexpr double kFastest = 0.6;        ///< rad/s or m/s; of a simulated robot 1.5
  static constexpr double kNear = 0.03;          ///< rad or m: the robot has arrived
  static constexpr int64_t kPeriod = 40000;      ///< us, of the set-points

  /// `run`: of the sender of the set-points.
  ArmMotion(const Chain& chain, int64_t run);

  /// What the robot measures, and what the bridge does.
  void robot(const JointVector& theta, const JointVector& velocity, bool simulated);
  void bridge(const bridge_state_t& state);

  /// Begins to move from where the robot is; nothing before its first state.
  void go_to(const JointVector& goal);
  /// Sends no more set-points: the bridge lets the robot decelerate.
  void stop() { goal_.reset(); }
  void tick(int64_t now_us, Outbox& out);

  bool moving() const { return goal_.has_value(); }
  /// Whether the robot stands at the goal.
  bool arrived() const;
  /// Why the robot does not move, and what to do; "" when it does.
  std::string obstacle() const;
  const std::optional<JointVector>& theta() const { return theta_; }

 private:
  Chain chain_;
  int64_t run_, sequence_ = 0, sent_us_ = 0;
  std::optional<JointVector> theta_, velocity_, goal_;
  std::optional<bridge_state_t> bridge_;
  JointVector from_;
  bool simulated_ = false;
  double duration_s_ = 1, elapsed_s_ = 0;
};

}  // namespace multireach
