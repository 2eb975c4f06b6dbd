#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace multireach {

struct MujocoArmOptions {
  double step_s = 0.001;
  double natural_frequency_rad_s = 100;  ///< of each joint's servo; the gains follow from it
  double damping_ratio = 1;
  std::map<std::string, double>
      start;  ///< joint positions at the beginning, rad or m; 0, or the nearest inside the limits, for others
};

/// A robot simulated by MuJoCo from its URDF, every joint under high-gain position control as by the Hoap2's own board:
/// the torque is M(q) (w^2 (q_wanted - q) + 2 z w (v_wanted - v)) plus what holds the arm's weight, within the URDF's
/// effort limit. Nothing collides: visual and collision shapes are left out.
class MujocoArm {
 public:
  /// `urdf_xml` is the file's text. Throws std::invalid_argument with a sentence when MuJoCo cannot load it, it has no
  /// hinge or slide joint, or `start` names a joint that it does not have
  /// or a position outside its limits.
  MujocoArm(const std::string& urdf_xml, const MujocoArmOptions& options);
  ~MujocoArm();

  const std::vector<std::string>& joint_names() const { return joint_names_; }
  /// Positions (rad or m), velocities (rad/s or m/s) and servo torques (N m or N), in the order of joint_names().
  std::vector<double> positions() const;
  std::vector<double> velocities() const;
  const std::vector<double>& torques() const { return torques_; }

  /// What a joint shall do from now on. Returns false for a joint that the robot does not have.
  bool command(const std::string& joint, double position, double velocity);
  /// Lets all joints stay at the last commanded position.
  void hold();
  /// A force (N, in the frame of the world) at the origin of a link, in place of any other, until `release`. Returns
  /// false, and changes nothing, for an unknown link or a force of 10 kN or more.
  bool push(const std::string& link, const Eigen::Vector3d& force_n);
  void release();
  /// Advances by one step. What follows depends on positions, velocities, commands and push alone: the solver starts
  /// from nothing at every step.
  void step();
  /// Puts the joints somewhere else, in the order of joint_names(). Returns false for other numbers of joints.
  bool set_state(const std::vector<double>& positions, const std::vector<double>& velocities);

 private:
  struct Simulation;
  std::unique_ptr<Simulation> simulation_;
  MujocoArmOptions options_;
  std::vector<std::string> joint_names_;
  std::vector<double> wanted_position_, wanted_velocity_, torques_, effort_;
};

}  // namespace multireach
