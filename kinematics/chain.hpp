#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/joint_vector.hpp"

namespace multireach {

/// One moving joint of a chain.
struct Joint {
  enum class Type { kRevolute, kContinuous, kPrismatic };

  std::string name;
  Type type = Type::kRevolute;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit vector in the joint's own frame
  double lower = 0;                                 ///< rad or m; -infinity for a continuous joint
  double upper = 0;                                 ///< rad or m; +infinity for a continuous joint
  double velocity = 0;                              ///< largest speed, rad/s or m/s; +infinity: unlimited
  double effort = 0;                                ///< largest torque or force, N m or N; +infinity: unlimited

  bool limited() const { return type != Type::kContinuous; }
};

/// A serial kinematic chain from a base link to a tip link: fixed transforms with joints between them. W is the base
/// link's frame, T the tip link's.
class Chain {
 public:
  /// `fixed` has one element more than `joints`: element i is the transform from the frame after joint i-1 (W for the
  /// first) to the frame of joint i; the last element leads from the frame after the last joint to T. Throws
  /// std::invalid_argument when the sizes do not agree, when there is no joint or more than kMaxJoints, when an axis is
  /// not a unit vector, or when a limit is invalid (not finite, lower above upper, a speed below 0).
  Chain(std::vector<Joint> joints, std::vector<Eigen::Isometry3d> fixed, std::string base, std::string tip);

  int size() const { return static_cast<int>(joints_.size()); }
  const Joint& joint(int i) const { return joints_[i]; }
  const std::vector<Joint>& joints() const { return joints_; }
  /// The fixed transform before joint i, or after the last one for i = size().
  const Eigen::Isometry3d& fixed(int i) const { return fixed_[i]; }
  const std::string& base() const { return base_; }
  const std::string& tip() const { return tip_; }
  /// Lower and upper position limits of the n joints; infinite for continuous joints.
  const JointVector& lower() const { return lower_; }
  const JointVector& upper() const { return upper_; }
  /// Speed limits of the n joints; infinite where the URDF gives none.
  const JointVector& velocity() const { return velocity_; }
  /// Index of the joint with this name, or -1.
  int index_of(std::string_view joint_name) const;

  /// p_WT = K(theta), Eq. (4): the tip's position in W, metres. `theta` has size() elements.
  Eigen::Vector3d position(const JointVector& theta) const;
  /// K(theta) and its 3 x n Jacobian, d p_WT / d theta, in W.
  void position_and_jacobian(const JointVector& theta, Eigen::Vector3d& p_WT, PositionJacobian& jacobian) const;
  /// X_WT: the tip's position and orientation in W.
  Eigen::Isometry3d pose(const JointVector& theta) const;
  /// X_WT and the 6 x n geometric Jacobian in W: the linear velocity of T's origin (rows 0-2) and the angular velocity
  /// (rows 3-5).
  void pose_and_jacobian(const JointVector& theta, Eigen::Isometry3d& X_WT, PoseJacobian& jacobian) const;

  /// Largest violation of a position limit over all joints, rad or m; 0 inside the limits.
  double limit_excess(const JointVector& theta) const;
  /// Upper bound of the distance between the first joint and the tip, m.
  double reach() const;
  /// The joint configuration with every joint clamped to its limits.
  JointVector clamped(const JointVector& theta) const;
  /// Range from which joint configurations are sampled: the limits; one whole turn for a continuous joint; the four
  /// turns nearest to 0 for a revolute joint with a range of more than four turns.
  double sample_lower(int i) const;
  double sample_upper(int i) const;

 private:
  bool has_multi_turn_range(int i) const;

  std::vector<Joint> joints_;
  std::vector<Eigen::Isometry3d> fixed_;
  std::string base_, tip_;
  JointVector lower_, upper_, velocity_;
};

/// Checks whether `theta` is a valid joint configuration of `chain`. Returns an error message that names the joint when
/// the number of joints is wrong, a value is not finite, or a limit is exceeded by more than `tolerance` (rad or m);
/// nothing when it is valid. `what` names the configuration in the message.
[[nodiscard]] std::optional<std::string> joint_configuration_fault(const Chain& chain, const std::vector<double>& theta,
                                                                   std::string_view what, double tolerance = 1e-9);

}  // namespace multireach
