#pragma once

#include <optional>
#include <span>
#include <vector>

#include "vision/fiducial/tag_detector.hpp"
#include "vision/fiducial/tag_edges.hpp"

namespace multireach::vision {

/// What one camera shows of a tag.
struct TagObservation {
  TagCamera camera;
  cv::Mat bgr;      ///< 8-bit; shares its pixels
  cv::Rect window;  ///< the part of it that is valid
  std::array<Eigen::Vector2d, 4> corners;
};

struct TagSize {
  double side_m = 0;       ///< of the black square
  double tolerance_m = 0;  ///< standard deviation of `side_m`
};

/// A pose that explains the images.
struct TagPose {
  TagPlacement tag;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();  ///< translation (m), rotation (rad)
  double chi2 = 0;
  int degrees_of_freedom = 0;                         ///< mean of chi2 where all cameras show one tag of this size
  std::vector<Eigen::Vector2d> measured_centre_px{};  ///< for each camera
};

struct TagFit {
  EdgeFault fault = EdgeFault::kNone;  ///< why the tag could not be measured in one of the images
  size_t faulty = 0;                   ///< which
  std::optional<TagPose> best;         ///< in the left camera's frame
  /// A plane seen from afar looks almost the same when it is mirrored about the line of sight (Schweighofer and Pinz,
  /// "Robust pose estimation from a planar target", PAMI 2006). That pose, where it explains the images about as well;
  /// only `tag` is set where its edges could not be measured.
  std::optional<TagPose> other;
};

/// Pose of a tag from one or more cameras: maximum likelihood over the edges of its black square in all images, with
/// Gauss-Newton steps from both poses that the corners allow. The covariance is the inverse of the information.
TagFit fit_tag(std::span<const TagObservation> observations, const TagSize& size, double sigma_px);

}  // namespace multireach::vision
