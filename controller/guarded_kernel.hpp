#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "controller/hand_target.hpp"
#include "controller/proximity.hpp"
#include "kinematics/joint_vector.hpp"

namespace multireach::controller {

/// All that the guarded law remembers between steps. Velocities are per step.
struct GuardedState {
  std::array<double, kMaxJoints> theta{};         ///< joint angles, rad or m
  std::array<double, kMaxJoints> velocity{};      ///< joint velocity
  std::array<double, kMaxJoints> theta_target{};  ///< theta_T
  std::array<double, kMaxJoints> push{};          ///< a displacement to be taken up, rad or m; zero without feedback
  std::array<double, 3> x{};                      ///< hand position K(theta), m, in W
  std::array<double, 3> x_target{};               ///< K(theta_T)
  std::array<double, 6> hand_velocity{};  ///< of the hand's task; rotation rows in metres (times orientation_length)
  double gamma = 0;                       ///< now
  double best_distance = 0;     ///< the least |theta_T - theta| since the target was new, in steps of some per cent
  double stalled_distance = 0;  ///< that at which the arm stalled last
  int idle_steps = 0;           ///< since best_distance fell
  int waited_steps = 0;         ///< since the target was new, or has moved away from `awaited`
  double ceiling = 0;           ///< what gamma may rise to
  double residual = 0;          ///< |target - hand at theta_T|, m
  std::array<double, 3> last_target{};     ///< position of the target in the step before
  std::array<double, 3> awaited{};         ///< position of the target when waited_steps was 0
  double caution = 1;                      ///< factor of the damping of theta_T's steps
  double watched_residual = 0;             ///< that at the last look
  std::array<double, 3> watched_target{};  ///< position of the target then
  int64_t steps = 0;
  bool posture_stuck = false;  ///< theta_T has stopped short of the target
  bool posture_fixed = false;  ///< theta_T shall stay as it is
  bool slow = false;           ///< the arm hardly moves although theta_T is elsewhere
  bool obstructed = false;     ///< a distance to keep changed the velocity in the last step
};

/// One arm under the guarded law, with the loops over joints unrolled where the number of joints was known to the
/// compiler. The state is the caller's.
class GuardedKernel {
 public:
  virtual ~GuardedKernel() = default;
  virtual std::unique_ptr<GuardedKernel> clone() const = 0;
  /// Must be called when theta or theta_target was changed from outside.
  virtual void refresh(GuardedState& state) = 0;
  /// The schedule of gamma begins anew, for a new target.
  virtual void forget_progress(GuardedState& state) const = 0;
  /// One integration step towards the target, with distances to keep. Returns the number of linear systems solved
  /// beyond the first.
  virtual int step(const HandTarget& target, std::span<const NearPair> pairs, GuardedState& state) = 0;
};

}  // namespace multireach::controller
