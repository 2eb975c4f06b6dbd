#pragma once

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
  virtual const Chain& chain() const = 0;
  virtual int blocks() const = 0;
  /// Arm a is lane a % kRowLanes of block a / kRowLanes.
  virtual const ArmBlock& block(int index) const = 0;
  int size() const { return blocks() * kRowLanes; }

  /// Puts an arm (0 to size() - 1) at rest at `theta` and gives it a target (m, in W), a target posture inside the
  /// limits that should meet it, and its own gamma (rad^2/m^2; default: that of the law's parameters). Returns false,
  /// and changes nothing, for an arm that there is not, and for what is not finite, of another size, or outside the
  /// limits.
  virtual bool start(int arm, const JointVector& theta, const Eigen::Vector3d& target, const JointVector& theta_target,
                     std::optional<double> gamma = {}) = 0;
  /// One integration step of every arm.
  virtual void step() = 0;
  /// How often theta_T was chosen anew, of all arms.
  virtual int64_t posture_choices() const = 0;

 protected:
  /// Whether start() may take these.
  bool acceptable(int arm, const JointVector& theta, const Eigen::Vector3d& target, const JointVector& theta_target,
                  std::optional<double> gamma) const;
  static JointVector theta_of(const ArmBlock& block, int lane, int n);
};

/// The instruction set that batches use here, as "AVX3" (Highway's names), and all that were compiled in and that this
/// processor has, the widest first.
std::string instruction_set();
std::vector<std::string> instruction_sets();
/// Makes batches use that one; for tests. Returns false for one that is not in instruction_sets(). Not while others
/// run.
bool use_instruction_set(const std::string& name);

}  // namespace multireach::controller
