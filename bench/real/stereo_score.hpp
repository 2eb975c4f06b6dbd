#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "bench/real/real_set.hpp"
#include "vision/stereo/triangulate.hpp"

namespace multireach::bench {

/// An answer to a pair of images: pixels in both, and the position in W with its covariance.
struct StereoAnswer {
  StereoPoint px;
  std::optional<Eigen::Vector3d> p_W;
  std::optional<Eigen::Matrix3d> covariance;
};

/// The position of a pair of labels, each with a standard deviation of half a pixel per coordinate. Where the rays miss
/// each other by more (a moving object, cameras that are not synchronised), the covariance grows accordingly. Nothing
/// where the rays do not meet before the cameras.
std::optional<vision::Triangulation> position_of_labels(const StereoRig& rig, const StereoPoint& px);

/// Answers of one method to the labels of a video of two cameras.
struct StereoScore {
  int labelled = 0;
  int right = 0;  ///< answers within kRight of the label in both images
  int wrong = 0;  ///< answers beyond kWrong in one
  std::vector<double> errors_mm;
  std::vector<double> squared_sigmas;  ///< squared Mahalanobis distances, by answer and label together

  void add(const StereoAnswer& answer, const StereoPoint& label, const vision::Triangulation& truth);
  void add(const StereoScore& other);
  double right_percent() const { return labelled > 0 ? 100.0 * right / labelled : 0; }
  double wrong_percent() const { return labelled > 0 ? 100.0 * wrong / labelled : 0; }

  /// Cells of a table: median and root mean square of the errors, mm.
  std::string error_cells() const;
  /// NEES/3, the share of the errors inside the 95 % ellipsoid, the largest error in standard deviations.
  std::string covariance_cells() const;
};

}  // namespace multireach::bench
