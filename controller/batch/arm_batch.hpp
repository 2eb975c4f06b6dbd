#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "controller/batch/arm_block.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

/// Many arms of one kind under one law, side by side in the lanes of the processor's registers (AVX-512, AVX2, SSE4,
/// NEON: the widest that it has, found at run time). Each goes to a position that rests, alone in the world. What an
/// arm does depends neither on the others nor on the processor, to the last bit. For studies, and for learning from
/// millions of reaches.
class ArmBatch {
 public:
  virtual ~ArmBatch() = default;
  const Chain& chain() const { return chain_; }
  int blocks() const { return static_cast<int>(running_.size()); }
  /// Arm a is lane a % kRowLanes of block a / kRowLanes.
  virtual const ArmBlock& block(int index) const = 0;
  int size() const { return blocks() * kRowLanes; }

  JointVector theta(int arm) const;
  Eigen::Vector3d x(int arm) const;  ///< m, in W

  /// Puts an arm (0 to size() - 1) at rest at `theta`, which may be outside the limits, and gives it a target (m, in
  /// W), a target posture inside the limits that should meet it, and its own gamma (rad^2/m^2; default: that of the
  /// law's parameters). Returns false, and changes nothing, for an arm that there is not, for what is not finite or of
  /// another size, for angles beyond 1e5 rad, and for a target posture outside the limits.
  virtual bool start(int arm, const JointVector& theta, const Eigen::Vector3d& target, const JointVector& theta_target,
                     std::optional<double> gamma = {}) = 0;
  /// From now on nothing is computed for this arm, until it is started again; as at first.
  void stop(int arm) { running_[static_cast<size_t>(arm / kRowLanes)] &= ~(1U << arm % kRowLanes); }
  /// One integration step of every arm that runs. What the others' numbers are then is not said.
  virtual void step() = 0;
  /// Of each block, a mask: bit a is set where the arm of lane a runs.
  const std::vector<uint32_t>& running() const { return running_; }
  /// How often theta_T was chosen anew, of all arms.
  int64_t posture_choices() const { return posture_choices_; }

 protected:
  /// Throws std::invalid_argument when `arms` is not positive.
  ArmBatch(const Chain& chain, int arms);
  /// Puts every arm at rest, at the zero posture or the nearest to it inside the limits, and stops it.
  void rest();
  void run(int arm) { running_[static_cast<size_t>(arm / kRowLanes)] |= 1U << arm % kRowLanes; }
  /// Whether start() may take these.
  bool acceptable(int arm, const JointVector& theta, const Eigen::Vector3d& target, const JointVector& theta_target,
                  std::optional<double> gamma) const;
  /// What every law begins with in a lane of a block: the posture, no velocity, the target.
  void begin(ArmBlock& block, int lane, const JointVector& theta, const Eigen::Vector3d& target) const;
  static Eigen::Vector3d target_of(const ArmBlock& block, int lane) {
    return {block.target[0][lane], block.target[1][lane], block.target[2][lane]};
  }

  int64_t posture_choices_ = 0;

 private:
  Chain chain_;
  std::vector<uint32_t> running_;
};

/// The instruction set that batches use here, as "AVX3" (Highway's names), and all that were compiled in and that this
/// processor has, the widest first; not while others run.
std::string instruction_set();
std::vector<std::string> instruction_sets();
/// Makes batches use that one; for tests. Returns false for one that is not in instruction_sets(). Not while others
/// run.
bool use_instruction_set(const std::string& name);

}  // namespace multireach::controller
