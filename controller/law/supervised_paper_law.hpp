#pragma once

#include <optional>

#include "controller/ik/multi_start.hpp"
#include "controller/law/paper_law.hpp"
#include "controller/law/reaching_law.hpp"

namespace multireach::controller {

/// The law `paper` with supervision, for a robot: Eqs. (19)-(28), and a search for theta_T when K(theta_T) is further
/// than `drift_m` from the target, or when theta_T is not finite or outside the limits. It does not pursue an
/// unreachable target but keeps the previous one. It handles positions only: it ignores the target's task and refuses
/// obstacles.
class SupervisedPaperLaw final : public ReachingLaw {
 public:
  /// Throws std::invalid_argument for invalid parameters.
  SupervisedPaperLaw(const Chain& chain, const PaperParameters& parameters, double drift_m, const IkOptions& search);

  const Chain& chain() const override { return chain_; }
  bool start(const JointVector& theta) override;
  TargetResult set_target(const TaskTarget& target) override;
  TargetResult update_target(const TaskTarget& target) override;
  bool set_joint_target(const JointVector& theta) override;
  void step() override;
  void compensate(const JointVector&) override {}
  int set_obstacles(std::span<const Obstacle> obstacles) override { return static_cast<int>(obstacles.size()); }

  Eigen::Map<const Eigen::VectorXd> theta() const override { return map(state_.theta); }
  Eigen::Map<const Eigen::VectorXd> velocity() const override { return map(state_.theta_dot); }
  Eigen::Map<const Eigen::VectorXd> theta_target() const override { return map(state_.theta_target); }
  Eigen::Vector3d x() const override { return state_.x; }
  Eigen::Vector3d x_target() const override { return target_ ? target_->position : state_.x; }
  JointVector weights() const override;
  double gamma() const override { return parameters_.gamma; }
  double residual_m() const override { return (x_target() - chain_.position(state_.theta_target)).norm(); }
  bool unreachable() const override { return unreachable_; }
  int64_t ik_searches() const override { return ik_searches_; }

 private:
  static Eigen::Map<const Eigen::VectorXd> map(const JointVector& values) { return {values.data(), values.size()}; }
  bool search_theta_target(const Eigen::Vector3d& x_T);

  Chain chain_;
  PaperParameters parameters_;
  double drift_m_;
  MultiStartIk search_;
  PaperState state_;
  std::optional<TaskTarget> target_;
  std::optional<JointVector> posture_;            // the goal of set_joint_target()
  std::optional<Eigen::Vector3d> failed_target_;  // the target for which the last search found no solution
  bool started_ = false, unreachable_ = false;
  int64_t ik_searches_ = 0;
};

}  // namespace multireach::controller
