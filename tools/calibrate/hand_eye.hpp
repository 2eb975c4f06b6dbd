#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace multireach {

/// One measurement of a target that the robot's hand holds: the target seen by the cameras, and the hand pose reported
/// by the robot.
struct HandEyeSample {
  Eigen::Vector3d p_LT = Eigen::Vector3d::Zero();          ///< the target in the left camera's frame, m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();    ///< of p_LT, m^2
  Eigen::Isometry3d X_WH = Eigen::Isometry3d::Identity();  ///< pose of the hand in the robot's base
};

struct HandEyeOptions {
  Eigen::Vector3d p_HT = Eigen::Vector3d::Zero();  ///< the target in the hand's frame, m
  bool estimate_offset = false;                    ///< p_HT is unknown and is estimated as well
  double hand_sigma_m = 0.001;                     ///< standard deviation of the reported hand position, per coordinate
};

struct HandEye {
  Eigen::Isometry3d X_WL = Eigen::Isometry3d::Identity();
  /// Covariance of X_WL: rotation (rad, about W's axes: exp(w) R_WL) and translation (m, in W).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector3d p_HT = Eigen::Vector3d::Zero();
  Eigen::Matrix3d offset_covariance = Eigen::Matrix3d::Zero();  ///< of p_HT, m^2; 0 if p_HT was given
  double rms_m = 0;                                             ///< of `distances_m`, without outliers
  double chi2_per_dof = 0;                                      ///< 1 if the positions' covariances are right
  std::vector<double> distances_m;                              ///< for each position: between seen and reported target
  std::vector<bool> outlier;                                    ///< for each position: not used
};

/// Solves for the pose of the left camera from X_WL p_LT = X_WH p_HT at all positions. Starts from the rigid fit
/// (Kabsch) with the least median of distances, then takes Gauss-Newton steps weighted by the positions' covariances,
/// without outliers, which fit far worse than their covariances say. If the residuals are larger than the covariances
/// say, the result's covariance is scaled by chi^2 per degree of freedom. Throws std::runtime_error, with a sentence on
/// what to do, when the positions do not determine the result: fewer than 4 (5 with an unknown offset), collinear
/// positions, orientations too similar to determine the offset, or contradictory positions.
HandEye solve_hand_eye(const std::vector<HandEyeSample>& samples, const HandEyeOptions& options = {});

}  // namespace multireach
