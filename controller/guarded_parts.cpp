#include "controller/guarded_parts.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "controller/guarded_kernel_of.hpp"
#include "kinematics/random.hpp"

namespace multireach::controller {
namespace {

using Tuning = GuardedTuning;

/// A target that was found out of reach is searched for again when it has moved this far, m.
constexpr double kSameTarget = 1e-3;
/// Steps that the arm may stand before an obstacle until a way around is looked for.
constexpr int kPatience = 35;
/// And at most, after several times without success.
constexpr int kMostPatience = 1400;
/// Of a push, no more than this is taken up at once, rad (m).
constexpr double kMostPush = 3;
/// Postures of a detour at most, and how near one must be passed, rad (m).
constexpr size_t kMostDetour = 64;
constexpr double kPassed = 0.15;
/// Random postures tried for one that meets the target without touching anything.
constexpr int kClearTries = 60;

template <int N>
std::unique_ptr<GuardedKernel> kernel_of(const Chain& chain, const Tool& tool, const GuardedSettings& settings) {
  return std::make_unique<GuardedKernelOf<N>>(chain, tool_frame(tool), settings);
}

std::unique_ptr<GuardedKernel> make_kernel(const Chain& chain, const Tool& tool, const GuardedSettings& settings) {
  switch (chain.size()) {
    case 2:
      return kernel_of<2>(chain, tool, settings);
    case 3:
      return kernel_of<3>(chain, tool, settings);
    case 4:
      return kernel_of<4>(chain, tool, settings);
    case 5:
      return kernel_of<5>(chain, tool, settings);
    case 6:
      return kernel_of<6>(chain, tool, settings);
    case 7:
      return kernel_of<7>(chain, tool, settings);
    case 8:
      return kernel_of<8>(chain, tool, settings);
    case 9:
      return kernel_of<9>(chain, tool, settings);
    default:
      return kernel_of<0>(chain, tool, settings);
  }
}

bool acceptable(const HandTarget& target) {
  if (!target.position.allFinite() || !target.velocity.allFinite()) return false;
  if (target.aim == Aim::kPointing) {
    return target.direction.allFinite() && std::abs(target.direction.norm() - 1) < 1e-6;
  }
  if (target.aim == Aim::kPose) {
    const Eigen::Matrix3d& R = target.orientation;
    return R.allFinite() && (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6 &&
           R.determinant() > 0;
  }
  return true;
}

}  // namespace

GuardedLaw::Parts::Parts(const Chain& chain, const GuardedParameters& parameters)
    : chain_(chain),
      parameters_(parameters),
      settings_(guarded_settings(chain, parameters)),
      search_(chain, parameters.posture_search, parameters.tool),
      solver_(chain, parameters.tool),
      proximity_(chain, parameters.body),
      planner_(chain),
      kernel_(make_kernel(chain, parameters.tool, settings_)) {
  detour_.reserve(kMostDetour);
  start(chain.clamped(JointVector::Zero(chain.size())));
}

GuardedLaw::Parts::Parts(const Parts& other)
    : chain_(other.chain_),
      parameters_(other.parameters_),
      settings_(other.settings_),
      search_(other.search_),
      solver_(other.solver_),
      proximity_(other.proximity_),
      planner_(other.chain_),
      kernel_(other.kernel_->clone()),
      state_(other.state_),
      target_(other.target_),
      asked_(other.asked_),
      posture_only_(other.posture_only_),
      out_of_reach_(other.out_of_reach_),
      quiet_until_(other.quiet_until_),
      distance_at_choice_(other.distance_at_choice_),
      chosen_for_(other.chosen_for_),
      detour_(other.detour_),
      detour_next_(other.detour_next_),
      obstructed_steps_(other.obstructed_steps_),
      patience_(other.patience_),
      plans_(other.plans_),
      posture_choices_(other.posture_choices_),
      bounded_solves_(other.bounded_solves_) {
  detour_.reserve(kMostDetour);
}

bool GuardedLaw::Parts::start(const JointVector& theta) {
  if (theta.size() != chain_.size() || !theta.allFinite() || theta.cwiseAbs().maxCoeff() > kLargestAngle) return false;
  state_ = GuardedState{};
  const JointVector inside = chain_.clamped(theta);
  for (int i = 0; i < chain_.size(); ++i) {
    state_.theta[i] = theta[i];
    state_.theta_target[i] = inside[i];
  }
  forget_progress();
  target_.reset();
  out_of_reach_ = false;
  quiet_until_ = 0;
  detour_.clear();
  detour_next_ = 0;
  obstructed_steps_ = 0;
  patience_ = kPatience;
  kernel_->refresh(state_);
  return true;
}

int GuardedLaw::Parts::set_obstacles(std::span<const Obstacle> obstacles) {
  if (parameters_.body.link_radius_m <= 0) return static_cast<int>(obstacles.size());
  const int refused = proximity_.set_obstacles(obstacles);
  if (on_detour()) end_detour();
  if (target_ && !posture_only_) target_->position = proximity_.outside_obstacles(asked_.position);
  return refused;
}

std::optional<JointVector> GuardedLaw::Parts::clear_posture(uint64_t seed, bool nearest) {
  const double tolerance = search_.options().tolerance_m;
  const CounterRandom random(seed, 11);
  std::optional<JointVector> best;
  uint64_t counter = 0;
  for (int k = 0; k < kClearTries && (nearest || !best); ++k) {
    JointVector posture(chain_.size());
    for (int i = 0; i < chain_.size(); ++i) {
      posture[i] = random.uniform(counter++, chain_.sample_lower(i), chain_.sample_upper(i));
    }
    if (solver_.solve(*target_, posture, tolerance) > tolerance) continue;
    if (best && (posture - theta()).norm() >= (*best - theta()).norm()) continue;
    if (proximity_.clearance(posture) >= 0) best = posture;
  }
  return best;
}

void GuardedLaw::Parts::end_detour() {
  if (detour_.empty()) return;
  const JointVector goal = detour_.back();
  detour_.clear();
  detour_next_ = 0;
  state_.posture_fixed = posture_only_;
  forget_progress();
  set_theta_target(goal);
}

void GuardedLaw::Parts::follow_detour() {
  while (on_detour() && (detour_[detour_next_] - theta()).norm() < kPassed) ++detour_next_;
  if (!on_detour()) {
    end_detour();
    return;
  }
  if (theta_target() == detour_[detour_next_]) return;
  for (int i = 0; i < chain_.size(); ++i) state_.theta_target[i] = detour_[detour_next_][i];
  kernel_->refresh(state_);
}

void GuardedLaw::Parts::watch_obstruction() {
  obstructed_steps_ = state_.obstructed && state_.slow ? obstructed_steps_ + 1 : 0;
  if (obstructed_steps_ < patience_) return;
  obstructed_steps_ = 0;
  // To the posture that was chosen, and when no way is found, in turns to others that meet the target.
  JointVector goal = on_detour() ? detour_.back() : JointVector(theta_target());
  const uint64_t seed = search_.options().seed + plans_;
  if (plans_++ % 2 == 1 && !posture_only_) goal = clear_posture(seed, false).value_or(goal);
  // A goal deeper in something than the arm is now cannot be gone to.
  const bool possible = proximity_.clearance(goal) >= std::min(0.0, proximity_.clearance(theta())) - 1e-6;
  const auto way = possible ? planner_.plan(theta(), goal, proximity_, seed) : std::span<const JointVector>{};
  if (way.empty() || way.size() > kMostDetour) {
    patience_ = std::min(2 * patience_, kMostPatience);
    if (on_detour()) end_detour();
    return;
  }
  // An arm that is outside its limits has a way that begins there.
  detour_.clear();
  for (const JointVector& posture : way) detour_.push_back(chain_.clamped(posture));
  detour_next_ = 0;
  state_.posture_fixed = true;
  state_.gamma = 0;  // along the planned joint angles, not straight with the hand
  follow_detour();
}

void GuardedLaw::Parts::forget_progress() {
  state_.gamma = settings_.gamma;
  kernel_->forget_progress(state_);
}

void GuardedLaw::Parts::set_theta_target(const JointVector& theta_target) {
  for (int i = 0; i < chain_.size(); ++i) state_.theta_target[i] = theta_target[i];
  state_.posture_stuck = false;
  state_.watched_residual = std::numeric_limits<double>::infinity();
  distance_at_choice_ = distance_to_go();
  chosen_for_ = target_->position;
  quiet_until_ = state_.steps + Tuning::kQuiet;
  kernel_->refresh(state_);
}

void GuardedLaw::Parts::choose_posture() {
  FoundPosture found = search_.best(*target_, theta());
  ++posture_choices_;
  out_of_reach_ = found.error_m > Tuning::kReached;
  if (!out_of_reach_ && !proximity_.idle() && proximity_.clearance(found.theta) < 0) {
    found.theta = clear_posture(search_.options().seed, true).value_or(found.theta);
  }
  set_theta_target(found.theta);
}

void GuardedLaw::Parts::set_target(const HandTarget& target) {
  if (!target_ || target_->aim != target.aim)
    std::fill(state_.hand_velocity.begin() + 3, state_.hand_velocity.end(), 0);
  asked_ = brought_near(chain_, target);
  target_ = asked_;
  target_->position = proximity_.outside_obstacles(asked_.position);
}

Aimed GuardedLaw::Parts::aim(const HandTarget& target) {
  if (!acceptable(target)) return Aimed::kRefused;
  set_target(target);
  posture_only_ = false;
  state_.posture_fixed = false;
  detour_.clear();
  detour_next_ = 0;
  patience_ = kPatience;
  forget_progress();
  choose_posture();
  return out_of_reach_ ? Aimed::kOutOfReach : Aimed::kWithinReach;
}

Aimed GuardedLaw::Parts::aim(const HandTarget& target, const JointVector& theta_target) {
  const bool posture = theta_target.size() == chain_.size() && theta_target.allFinite() &&
                       chain_.limit_excess(theta_target) <= 0 && theta_target.cwiseAbs().maxCoeff() <= kLargestAngle;
  if (!acceptable(target) || !posture) return Aimed::kRefused;
  set_target(target);
  posture_only_ = false;
  state_.posture_fixed = false;
  detour_.clear();
  detour_next_ = 0;
  forget_progress();
  out_of_reach_ = false;
  set_theta_target(theta_target);
  return Aimed::kWithinReach;
}

Aimed GuardedLaw::Parts::follow(const HandTarget& target) {
  if (!target_ || posture_only_ || target.aim != target_->aim) return aim(target);
  if (!acceptable(target)) return Aimed::kRefused;
  set_target(target);
  return out_of_reach_ ? Aimed::kOutOfReach : Aimed::kWithinReach;
}

bool GuardedLaw::Parts::aim_at_posture(const JointVector& theta) {
  if (theta.size() != chain_.size() || !theta.allFinite() || chain_.limit_excess(theta) > 0) return false;
  if (theta.cwiseAbs().maxCoeff() > kLargestAngle) return false;
  target_ = HandTarget{.position = chain_.position(theta)};
  posture_only_ = true;
  detour_.clear();
  detour_next_ = 0;
  state_.posture_fixed = true;
  forget_progress();
  out_of_reach_ = false;
  set_theta_target(theta);
  return true;
}

void GuardedLaw::Parts::take_up(const JointVector& displacement) {
  if (displacement.size() != chain_.size() || !displacement.allFinite()) return;
  // As strong as the joints' own attractor would be at five times that distance.
  for (int i = 0; i < chain_.size(); ++i) {
    state_.push[i] = 5 * parameters_.gains.beta * std::clamp(displacement[i], -kMostPush, kMostPush);
  }
}

double GuardedLaw::Parts::distance_to_go() const {
  double sum = 0;
  for (int i = 0; i < chain_.size(); ++i) {
    const double apart = state_.theta_target[i] - state_.theta[i];
    sum += apart * apart;
  }
  return std::sqrt(sum);
}

void GuardedLaw::Parts::watch() {
  if (posture_only_ || state_.steps < quiet_until_) return;
  const double distance = distance_to_go();
  distance_at_choice_ = std::min(distance_at_choice_, distance);
  const bool strayed = distance > Tuning::kStrayed * distance_at_choice_ + Tuning::kStrayedBy;
  const bool known = out_of_reach_ && (target_->position - chosen_for_).norm() < kSameTarget;
  const bool stuck = state_.posture_stuck && !known;
  if (!strayed && !stuck) {
    if (out_of_reach_ && state_.residual < Tuning::kReached) out_of_reach_ = false;
    quiet_until_ = state_.steps + Tuning::kLookAgain;
    return;
  }
  choose_posture();
}

void GuardedLaw::Parts::step() {
  const std::span<const NearPair> pairs =
      proximity_.idle() ? std::span<const NearPair>{} : proximity_.near_pairs(theta());
  if (!target_) {
    HandTarget stay{.position = Eigen::Map<const Eigen::Vector3d>(state_.x.data())};
    state_.posture_fixed = true;
    bounded_solves_ += kernel_->step(stay, pairs, state_);
    return;
  }
  bounded_solves_ += kernel_->step(*target_, pairs, state_);
  target_->position += target_->velocity;
  asked_.position += target_->velocity;
  if (!pairs.empty()) watch_obstruction();
  if (on_detour()) {
    follow_detour();
  } else {
    watch();
  }
}

}  // namespace multireach::controller
