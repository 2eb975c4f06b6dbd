#include "controller/batch/guarded_batch.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "controller/batch/guarded_batch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "controller/batch/block_lanes-inl.hpp"
#include "controller/law/guarded_settings.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::controller {
namespace HWY_NAMESPACE {

#include "controller/qp/velocity_bounds.inl.hpp"

#include "numeric/interval.inl.hpp"

#include "controller/qp/box_qp.inl.hpp"

#include "controller/law/guarded_step.inl.hpp"

/// Accessor of the arms `first` to first + kWidth - 1 of a block for GuardedStep, with N joints (0: any number). Their
/// targets are fixed positions; there is no collision avoidance.
template <int N>
class BlockArms {
 public:
  using Scalar = Lanes;
  using Mask = LanesMask;
  using Register = Lanes;
  static constexpr int kRows = 3, kRegisters = 2;  // theta and theta_T have one register each
  static constexpr bool kDisturbed = false;        // no disturbance compensation, no moving target
  static constexpr size_t kCapacity = N == 0 ? kMaxJoints : N;
  using Joints = std::array<Lanes, kCapacity>;
  using Task = std::array<Lanes, 3>;
  using Rows = std::array<std::array<Joints, 3>, 2>;

  BlockArms(const GuardedConstants& constants, GuardedBlock& block, int first)
      : constants_(constants), block_(block), first_(first) {}

  HWY_INLINE const GuardedSettings& settings() const { return constants_.settings; }
  HWY_INLINE GuardedProgress<Row>& progress() { return block_.progress; }
  HWY_INLINE int size() const { return N == 0 ? constants_.arm.size : N; }

  static HWY_INLINE LanesMask none() { return no_lane(); }
  HWY_INLINE Lanes get(const Row& row) const { return load(row, first_); }
  HWY_INLINE void put(Lanes value, Row& row) const { store(value, row, first_); }
  template <int kRegister>
  static HWY_INLINE Lanes in_register(Lanes now, Lanes goal) {
    return kRegister == 0 ? now : goal;
  }
  template <int kRegister>
  static HWY_INLINE Lanes weighted(Lanes gamma, Lanes lanes) {
    return kRegister == 0 ? gamma * lanes : lanes;
  }
  static HWY_INLINE Lanes now(Lanes lanes) { return lanes; }
  static HWY_INLINE Lanes goal(Lanes lanes) { return lanes; }
  static HWY_INLINE const Joints& now_joints(const std::array<Joints, 2>& both, int) { return both[0]; }
  static HWY_INLINE const std::array<Joints, 3>& now_rows(const Rows& J, int) { return J[0]; }

  HWY_INLINE Lanes gamma() const { return get(block_.gamma); }
  static HWY_INLINE void set_slow(LanesMask) {}
  HWY_INLINE void set_gamma(Lanes value) { put(value, block_.gamma); }
  HWY_INLINE Lanes theta(int i) const { return get(block_.joints[i].theta); }
  HWY_INLINE Lanes theta_target(int i) const { return get(block_.joints[i].theta_target); }
  HWY_INLINE Lanes velocity(int i) const { return get(block_.joints[i].velocity); }
  HWY_INLINE Lanes hand_velocity(int m) const { return get(block_.hand_velocity[m]); }
  HWY_INLINE void set_hand_velocity(int m, Lanes value) { put(value, block_.hand_velocity[m]); }
  HWY_INLINE void set_joint(int i, Lanes velocity, Lanes theta, Lanes theta_target) {
    put(velocity, block_.joints[i].velocity);
    put(theta, block_.joints[i].theta);
    put(theta_target, block_.joints[i].theta_target);
  }

  static HWY_INLINE LanesMask target_rests() { return !no_lane(); }
  static constexpr bool target_moves() { return false; }
  static HWY_INLINE Lanes target_velocity(int) { return 0; }
  static constexpr bool target_fixed() { return false; }
  static HWY_INLINE LanesMask target_moved_away() { return no_lane(); }
  static HWY_INLINE Lanes target_moved_since_check() { return 0; }
  static constexpr bool obstructed() { return false; }
  static constexpr bool obstructs(const Joints&) { return false; }
  static int avoid(const Rows&, Lanes, const std::array<Joints, 2>&, const Task&, const Joints&, const Joints&,
                   Joints&) {
    return 0;
  }

  HWY_INLINE void task(Rows& J, Task& error, Task& residual) const {
    for (int m = 0; m < 3; ++m) {
      const Lanes x_target = get(block_.x_target[m]);
      error[m] = x_target - get(block_.x[m]);
      residual[m] = get(block_.target[m]) - x_target;
      for (int i = 0; i < size(); ++i) {
        J[0][m][i] = get(block_.joints[i].jacobian[m]);
        J[1][m][i] = get(block_.joints[i].jacobian_target[m]);
      }
    }
  }

  HWY_INLINE void update_kinematics() {
    HWY_NAMESPACE::update_kinematics<N, false>(constants_.arm, block_, first_);
    HWY_NAMESPACE::update_kinematics<N, true>(constants_.arm, block_, first_);
  }

 private:
  const GuardedConstants& constants_;
  GuardedBlock& block_;
  int first_;
};

template <int N>
uint32_t step_arms(const GuardedConstants& constants, GuardedBlock& block) {
  return step_block([&](int first) {
    BlockArms<N> arms(constants, block, first);
    GuardedStep<BlockArms<N>> step(arms);
    step.step();
    return step.needs_search(!no_lane());
  });
}

// Unrolled for the Hoap2's four joints. For seven joints, unrolled code exceeds the processor's instruction cache and
// is no faster than loops.
uint32_t step_guarded(const GuardedConstants& constants, GuardedBlock& block) {
  return constants.arm.size == 4 ? step_arms<4>(constants, block) : step_arms<0>(constants, block);
}

void refresh_guarded(const GuardedConstants& constants, GuardedBlock& block) {
  update_block(constants.arm, block);
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach::controller
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace multireach::controller {

HWY_EXPORT(step_guarded);
HWY_EXPORT(refresh_guarded);

GuardedBatch::GuardedBatch(const Chain& chain, const GuardedParameters& parameters, int arms)
    : ArmBatch(chain, arms),
      constants_{FastLinks<0, double>(chain, tool_frame(parameters.tool)), guarded_settings(chain, parameters)},
      search_(chain, guarded_ik_options(chain, parameters), parameters.tool) {
  if (parameters.body.link_radius_m > 0) throw std::invalid_argument("a batch has no body: link_radius_m must be 0");
  if (parameters.path_work > 0) throw std::invalid_argument("a batch plans no paths: path_work must be 0");
  blocks_.resize(running().size());
  searching_.resize(running().size());
  searches_.resize(static_cast<size_t>(size()));
  reset_all();
}

bool GuardedBatch::start(int arm, const JointVector& theta, const Eigen::Vector3d& target,
                         const JointVector& theta_target, std::optional<double> gamma) {
  if (!start_is_valid(arm, theta, target, theta_target, gamma)) return false;
  GuardedBlock& block = blocks_[static_cast<size_t>(arm / kRowLanes)];
  const int lane = arm % kRowLanes;
  const double infinity = std::numeric_limits<double>::infinity();
  init_lane(block, lane, theta, within_ten_reaches(chain(), {.position = target}).position);
  GuardedProgress<Row>& progress = block.progress;
  progress.gamma_max[lane] = progress.gamma_ceiling[lane] = block.gamma[lane] =
      gamma.value_or(constants_.settings.gamma);
  progress.best_distance[lane] = progress.stalled_distance[lane] = progress.residual[lane] = infinity;
  progress.damping_factor[lane] = 1;
  progress.steps_to_check[lane] = constants_.settings.pace.check_every;
  for (Row* row : {&progress.idle_steps, &progress.waited_steps, &progress.steps, &progress.unreachable}) {
    (*row)[lane] = 0;
  }
  set_theta_target(block, lane, theta_target);
  searching_[static_cast<size_t>(arm / kRowLanes)] &= ~(1U << lane);
  run(arm);
  return true;
}

void GuardedBatch::set_theta_target(GuardedBlock& block, int lane, const JointVector& theta_target) {
  double distance2 = 0;
  for (int i = 0; i < chain().size(); ++i) {
    const double posture = search_.locked()[i] ? block.joints[i].theta[lane] : theta_target[i];
    block.joints[i].theta_target[lane] = posture;
    const double apart = posture - block.joints[i].theta[lane];
    distance2 += apart * apart;
  }
  block.progress.stuck[lane] = 0;
  block.progress.checked_residual[lane] = std::numeric_limits<double>::infinity();
  block.progress.distance_at_choice[lane] = std::sqrt(distance2);
  block.progress.no_search_before[lane] = block.progress.steps[lane] + constants_.settings.pace.quiet;
  HWY_DYNAMIC_DISPATCH(refresh_guarded)(constants_, block);
}

void GuardedBatch::begin_search(int arm) {
  GuardedBlock& block = blocks_[static_cast<size_t>(arm / kRowLanes)];
  const int lane = arm % kRowLanes;
  search_.begin({.position = target_of(block, lane)}, theta(arm), searches_[static_cast<size_t>(arm)]);
  ++ik_searches_;
  searching_[static_cast<size_t>(arm / kRowLanes)] |= 1U << lane;
  block.progress.no_search_before[lane] = std::numeric_limits<double>::infinity();  // until this search is complete
}

void GuardedBatch::continue_search(int arm) {
  IkSearch& search = searches_[static_cast<size_t>(arm)];
  if (!search_.continue_search(search, constants_.settings.pace.search_work(TaskKind::kPosition))) return;
  GuardedBlock& block = blocks_[static_cast<size_t>(arm / kRowLanes)];
  const int lane = arm % kRowLanes;
  searching_[static_cast<size_t>(arm / kRowLanes)] &= ~(1U << lane);
  block.progress.unreachable[lane] = search.best.error_m > GuardedTuning::kReached ? 1 : 0;
  set_theta_target(block, lane, search.best.theta);
}

void GuardedBatch::step() {
  const auto step_block = HWY_DYNAMIC_DISPATCH(step_guarded);
  const auto each = [](size_t b, uint32_t lanes, auto&& visit) {
    for (int lane = 0; lanes >> lane != 0; ++lane) {
      if (lanes >> lane & 1) visit(static_cast<int>(b) * kRowLanes + lane);
    }
  };
  for (size_t b = 0; b < blocks_.size(); ++b) {
    if (running()[b] == 0) continue;
    each(b, step_block(constants_, blocks_[b]) & running()[b], [&](int arm) { begin_search(arm); });
    each(b, searching_[b] & running()[b], [&](int arm) { continue_search(arm); });
  }
}

}  // namespace multireach::controller
#endif
