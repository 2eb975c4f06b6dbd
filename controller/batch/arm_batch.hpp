#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "controller/batch/arm_block.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

/// Many arms of one kind under one law, computed in SIMD lanes (AVX-512, AVX2, SSE4, NEON: the widest available,
/// selected at run time). Each arm goes to a fixed position target, without obstacles. Results are bit-identical for
/// any number of arms and any processor. For studies, and for learning from millions of reaches.
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

  /// Puts an arm (0 to size() - 1) at rest at `theta`, which may be outside the limits, and sets its target (m, in W),
  /// its theta_T, which should be an IK solution of the target, and its gamma (rad^2/m^2; default: that of the law's
  /// parameters). Returns false, and changes nothing, for an invalid arm number, for values that are not finite or have
  /// another size, for angles beyond 1e5 rad, for a theta_T outside the limits, and for a gamma outside [0, 1e12].
  virtual bool start(int arm, const JointVector& theta, const Eigen::Vector3d& target, const JointVector& theta_target,
                     std::optional<double> gamma = {}) = 0;
  /// Stops computing this arm until start() is called again. Initially all arms are stopped.
  void stop(int arm) { running_[static_cast<size_t>(arm / kRowLanes)] &= ~(1U << arm % kRowLanes); }
  /// One integration step of every running arm. The numbers of stopped arms are undefined afterwards.
  virtual void step() = 0;
  /// A mask for each block: bit a is set while the arm of lane a runs.
  const std::vector<uint32_t>& running() const { return running_; }
  /// Number of searches for theta_T, of all arms.
  int64_t ik_searches() const { return ik_searches_; }

 protected:
  /// Throws std::invalid_argument when `arms` is not positive.
  ArmBatch(const Chain& chain, int arms);
  /// Puts every arm at rest at the zero configuration, clamped to the limits, and stops it.
  void reset_all();
  void run(int arm) { running_[static_cast<size_t>(arm / kRowLanes)] |= 1U << arm % kRowLanes; }
  /// Whether these arguments of start() are valid.
  bool start_is_valid(int arm, const JointVector& theta, const Eigen::Vector3d& target, const JointVector& theta_target,
                      std::optional<double> gamma) const;
  /// Initialises a lane of a block for any law: joint positions, zero velocity, target.
  void init_lane(ArmBlock& block, int lane, const JointVector& theta, const Eigen::Vector3d& target) const;
  static Eigen::Vector3d target_of(const ArmBlock& block, int lane) {
    return {block.target[0][lane], block.target[1][lane], block.target[2][lane]};
  }

  int64_t ik_searches_ = 0;

 private:
  Chain chain_;
  std::vector<uint32_t> running_;
};

}  // namespace multireach::controller
