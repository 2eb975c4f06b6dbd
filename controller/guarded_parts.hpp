#pragma once

#include <optional>
#include <span>
#include <vector>

#include "controller/detour.hpp"
#include "controller/guarded_kernel.hpp"
#include "controller/guarded_law.hpp"
#include "controller/guarded_settings.hpp"
#include "controller/posture_search.hpp"
#include "controller/proximity.hpp"

namespace multireach::controller {

/// What GuardedLaw is made of: the steps themselves are its kernel's; here is when theta_T is chosen, and the way
/// around what is in the way. Functions of the same names as the law's do what is said there.
class GuardedLaw::Parts {
 public:
  Parts(const Chain& chain, const GuardedParameters& parameters);
  Parts(const Parts& other);

  bool start(const JointVector& theta);
  Aimed aim(const HandTarget& target);
  Aimed aim(const HandTarget& target, const JointVector& theta_target);
  Aimed follow(const HandTarget& target);
  bool aim_at_posture(const JointVector& theta);
  int set_obstacles(std::span<const Obstacle> obstacles);
  void take_up(const JointVector& displacement);
  void step();

  const Chain& chain() const { return chain_; }
  const GuardedState& state() const { return state_; }
  const GuardedSettings& settings() const { return settings_; }
  bool out_of_reach() const { return out_of_reach_; }
  bool on_detour() const { return detour_next_ < detour_.size(); }
  int64_t posture_choices() const { return posture_choices_; }
  int64_t bounded_solves() const { return bounded_solves_; }
  double clearance() { return proximity_.clearance(theta()); }
  Eigen::Map<const Eigen::VectorXd> map(const std::array<double, kMaxJoints>& values) const {
    return {values.data(), chain_.size()};
  }
  Eigen::Map<const Eigen::VectorXd> theta() const { return map(state_.theta); }
  Eigen::Map<const Eigen::VectorXd> theta_target() const { return map(state_.theta_target); }

 private:
  void set_target(const HandTarget& target);
  void forget_progress();
  void choose_posture();
  void set_theta_target(const JointVector& theta_target);
  /// |theta_T - theta|, added up joint by joint, so that many arms side by side get the same bits.
  double distance_to_go() const;
  void watch();
  void watch_obstruction();
  void follow_detour();
  void end_detour();
  /// A posture that meets the target and touches nothing, of some random ones: the nearest, or the first.
  std::optional<JointVector> clear_posture(uint64_t seed, bool nearest);

  Chain chain_;
  GuardedParameters parameters_;
  GuardedSettings settings_;
  PostureSearch search_;
  PostureSolver solver_;
  Proximity proximity_;
  Detour planner_;
  std::unique_ptr<GuardedKernel> kernel_;
  GuardedState state_;
  std::optional<HandTarget> target_;
  HandTarget asked_;  // as it was given, where target_ was moved out of obstacles
  bool posture_only_ = false, out_of_reach_ = false;
  int64_t quiet_until_ = 0;        // no search before this step
  double distance_at_choice_ = 0;  // |theta_T - theta| when theta_T was chosen, or the least since
  Eigen::Vector3d chosen_for_ = Eigen::Vector3d::Zero();  // the target then
  std::vector<JointVector> detour_;                       // postures to pass, the last one theta_T
  size_t detour_next_ = 0;
  int obstructed_steps_ = 0, patience_ = 0;
  uint64_t plans_ = 0;
  int64_t posture_choices_ = 0, bounded_solves_ = 0;
};

}  // namespace multireach::controller
