#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace multireach {

/// The target, held by the robot's hand, as the cameras see it and where the robot says that the hand is.
struct HandEyePlace {
  Eigen::Vector3d p_LT = Eigen::Vector3d::Zero();          ///< the target in the left camera's frame, m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();    ///< of p_LT, m^2
  Eigen::Isometry3d X_WH = Eigen::Isometry3d::Identity();  ///< the hand in the robot's base
};

struct HandEyeOptions {
  Eigen::Vector3d p_HT = Eigen::Vector3d::Zero();  ///< the target in the hand's frame, m
  bool estimate_offset = false;                    ///< p_HT is unknown, and estimated too
  double hand_sigma_m = 0.001;                     ///< standard deviation of what the robot says, per coordinate
};

struct HandEye {
  Eigen::Isometry3d X_WL = Eigen::Isometry3d::Identity();
  /// Of X_WL: rotation (rad, about W's axes: exp(w) R_WL) and translation (m, in W).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector3d p_HT = Eigen::Vector3d::Zero();
  Eigen::Matrix3d offset_covariance = Eigen::Matrix3d::Zero();  ///< of p_HT, m^2; 0 where it was given
  double rms_m = 0;                                             ///< of the distances of the places used
  double chi2_per_dof = 0;                                      ///< 1 where the covariances of the places are right
  std::vector<double> distances_m;  ///< for each place: between what is seen and what the robot says
  std::vector<bool> outlier;        ///< for each place: not used
};

/// Where the left camera is, from X_WL p_LT = X_WH p_HT at all places: the rigid fit (Kabsch) that leaves the least
/// median of distances, then Gauss-Newton steps with the places' covariances, without those that fit far worse than
/// these say. Where the residuals are larger than the covariances say, the result's is enlarged by chi^2 per degree of
/// freedom. Throws std::runtime_error, with a sentence on what to do, when the places do not determine the result:
/// fewer than 4 (5 with an unknown offset), on a line, orientations too much alike for the offset, or disagreeing.
HandEye solve_hand_eye(const std::vector<HandEyePlace>& places, const HandEyeOptions& options = {});

}  // namespace multireach
