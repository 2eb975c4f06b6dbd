#pragma once

#include <optional>
#include <string>
#include <vector>

#include "imaging/stereo_rig.hpp"
#include "kinematics/chain.hpp"
#include "tools/calibrate/hand_eye.hpp"

namespace multireach {

/// Which data of a log to use.
struct LogChoice {
  std::string target;      ///< the target's name; "" if there is only one
  double still_m = 0.002;  ///< the hand counts as standing still while it stays within this
  /// The cameras that the targets were seen with. The errors of their calibration are part of every covariance in the
  /// log; they are the same at all positions, so they are removed.
  std::optional<StereoRig> rig{};
};

/// Collects the positions at which a hand that holds the target stands still, message by message.
class Standstills {
 public:
  explicit Standstills(double still_m) : still_m_(still_m) {}

  /// A hand pose (X_WH) reported at `utime`, microseconds.
  void hand(const Eigen::Isometry3d& X_WH, int64_t utime);
  /// The target seen at a position in the left camera's frame, m; ignored when it is not finite.
  void target(const Eigen::Vector3d& p_LT, const Eigen::Matrix3d& covariance, int64_t utime);
  /// Ends the current standstill, as a motion of the hand does.
  void end();
  /// How many measurements of the target the current standstill has.
  int count() const { return current_ ? current_->count : 0; }
  /// Of the standstills that have ended and during which the target did not move: the means.
  const std::vector<HandEyeSample>& samples() const { return samples_; }
  /// Throws std::runtime_error when the target moved in more than one standstill and in more than a quarter of them.
  void require_held() const;

 private:
  struct Current {  // value-initialised: Clang does not take initialisers here in an optional
    HandEyeSample mean;
    int64_t begin_utime;
    int count;
    bool target_moved;
  };
  double still_m_;
  std::optional<Current> current_;
  std::vector<HandEyeSample> samples_;
  size_t target_moved_ = 0;
};

/// The positions at which the hand stood still and the target was seen. Hand poses come from ROBOT_STATE by forward
/// kinematics; target positions come from TARGET, transformed back by `X_WL`, the camera pose that the vision stage
/// used. Each standstill gives one position: the mean of the measurements after its first 0.3 s, so offsets between the
/// robot's and the cameras' clocks, and delays, do not matter. Targets of status UNCALIBRATED are in the left camera's
/// frame already; `X_WL` nothing: only such targets are expected. A standstill during which the target moves gives
/// none: the hand does not hold the target, or something else was seen. Throws InputError when the log holds no such
/// data, and std::runtime_error when the target moves in more than one standstill and in more than a quarter of them: a
/// hand that follows the target would only reproduce the old camera pose.
std::vector<HandEyeSample> samples_from_log(const std::string& path, const Chain& chain,
                                            const std::optional<Eigen::Isometry3d>& X_WL, const LogChoice& choice);

/// Reads such positions from a table with the columns seen_x_m, seen_y_m, seen_z_m (in the left camera's frame),
/// hand_x_m, hand_y_m, hand_z_m (in the robot's base), and optionally hand_qw, hand_qx, hand_qy, hand_qz (the hand's
/// orientation) and sigma_m (standard deviation of the seen position per coordinate; default: `sigma_m`). Throws
/// InputError that names file and line.
std::vector<HandEyeSample> samples_from_csv(const std::string& path, double sigma_m);

}  // namespace multireach
