#pragma once

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace multireach {

/// `start` names an unknown joint, or a position outside its limits.
class StartPositionError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

struct MujocoArmOptions {
  double step_s = 0.001;
  double natural_frequency_rad_s = 100;  ///< of each joint's servo; determines the gains
  double damping_ratio = 1;
  /// Initial joint positions, rad or m. Other joints start at default_joint_position().
  std::map<std::string, double> start{};
  /// Joints with the URDF's effort limits; all if empty. The others, as those of a robot's other arm, hold their
  /// position with any effort: they must not disturb the arm.
  std::vector<std::string> limited{};
};

/// A robot simulated by MuJoCo from its URDF. Every joint has high-gain position control, like that of the Hoap2's own
/// board: the torque is M(q) (w^2 (q_wanted - q) + 2 z w (v_wanted - v)) plus the bias torques (gravity, Coriolis and
/// centrifugal), within the URDF's effort limit. No joint accelerates beyond the URDF's velocity limit. Where a drive
/// cannot give its torque, all joints accelerate less together, unless the arm is pushed. The drives compensate
/// friction and damping, which are not simulated. There are no collisions: visual and collision shapes are removed.
class MujocoArm {
 public:
  /// `urdf_xml` is the text of the URDF file. Throws std::invalid_argument with a message when MuJoCo cannot load it,
  /// when it has no hinge or slide joint, or a floating or planar one, when a mass or inertia is negative or not a
  /// number; StartPositionError for `start`. MuJoCo's warnings go to the log.
  MujocoArm(const std::string& urdf_xml, const MujocoArmOptions& options);
  ~MujocoArm();

  const std::vector<std::string>& joint_names() const { return joint_names_; }
  /// Positions (rad or m), velocities (rad/s or m/s) and servo torques (N m or N), in the order of joint_names().
  std::vector<double> positions() const;
  std::vector<double> velocities() const;
  const std::vector<double>& torques() const { return torques_; }

  /// Sets the commanded position and velocity of a joint. Returns false for an unknown joint.
  bool command(const std::string& joint, double position, double velocity);
  /// Makes all joints hold the last commanded position.
  void hold();
  /// Applies a force (N, in the world frame) at the origin of a link until release(); it replaces any earlier force.
  /// Returns false, and changes nothing, for an unknown link or a force of 10 kN or more.
  bool push(const std::string& link, const Eigen::Vector3d& force_n);
  void release();
  /// Advances by one step. The result depends only on positions, velocities, commands and push, because the solver's
  /// warm start is off.
  void step();
  /// Sets joint positions and velocities, in the order of joint_names(). Returns false for a wrong number of joints.
  bool set_state(const std::vector<double>& positions, const std::vector<double>& velocities);

 private:
  struct Simulation;
  std::unique_ptr<Simulation> simulation_;
  MujocoArmOptions options_;
  std::vector<std::string> joint_names_;
  std::vector<double> wanted_position_, wanted_velocity_, torques_, effort_, fastest_;
};

}  // namespace multireach
