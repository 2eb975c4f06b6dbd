#pragma once

#include <optional>

#include "controller/ik/posture_search.hpp"
#include "controller/law/paper_law.hpp"
#include "controller/law/reaching_law.hpp"

namespace multireach::controller {

/// The law `paper` as it can live on a robot: Eqs. (19)-(28), and theta_T chosen anew when K(theta_T) is further than
/// `drift_m` from the target, when it is not finite, or when it is outside the limits. A target out of reach is not
/// pursued: the one before is kept. Positions only: a target's aim is
/// not looked at, and obstacles are refused.
class WatchedPaperLaw final : public ReachingLaw {
 public:
  /// Throws std::invalid_argument for parameters that make no sense.
  WatchedPaperLaw(const Chain& chain, const PaperParameters& parameters, double drift_m,
                  const PostureSearchOptions& search);

  const Chain& chain() const override { return chain_; }
  bool start(const JointVector& theta) override;
  Aimed aim(const HandTarget& target) override;
  Aimed follow(const HandTarget& target) override;
  bool aim_at_posture(const JointVector& theta) override;
  void step() override;
  void take_up(const JointVector&) override {}
  int set_obstacles(std::span<const Obstacle> obstacles) override { return static_cast<int>(obstacles.size()); }

  Eigen::Map<const Eigen::VectorXd> theta() const override { return map(state_.theta); }
  Eigen::Map<const Eigen::VectorXd> velocity() const override { return map(state_.theta_dot); }
  Eigen::Map<const Eigen::VectorXd> theta_target() const override { return map(state_.theta_target); }
  Eigen::Vector3d x() const override { return state_.x; }
  Eigen::Vector3d x_target() const override { return target_ ? target_->position : state_.x; }
  JointVector weights() const override;
  double gamma() const override { return parameters_.gamma; }
  double residual_m() const override { return (x_target() - chain_.position(state_.theta_target)).norm(); }
  bool out_of_reach() const override { return out_of_reach_; }
  int64_t posture_choices() const override { return posture_choices_; }

 private:
  static Eigen::Map<const Eigen::VectorXd> map(const JointVector& values) { return {values.data(), values.size()}; }
  bool choose_posture(const Eigen::Vector3d& x_T);

  Chain chain_;
  PaperParameters parameters_;
  double drift_m_;
  PostureSearch search_;
  PaperState state_;
  std::optional<HandTarget> target_;
  std::optional<JointVector> posture_;          // the goal, when it is a posture
  std::optional<Eigen::Vector3d> unreachable_;  // the target for which the last search found no posture
  bool out_of_reach_ = false;
  int64_t posture_choices_ = 0;
};

}  // namespace multireach::controller
