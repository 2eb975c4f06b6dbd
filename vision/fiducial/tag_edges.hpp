#pragma once

#include <Eigen/Geometry>
#include <array>
#include <opencv2/core.hpp>

#include "imaging/camera_model.hpp"

namespace multireach::vision {

/// Pose of a tag in the left camera's frame, and the factor of its size.
struct TagPlacement {
  Eigen::Isometry3d X_LT = Eigen::Isometry3d::Identity();
  double scale = 1;  ///< of the size that the caller gave
};

/// Unknowns of a tag's pose: a translation and a rotation vector about the tag's centre, both in the left camera's
/// frame, and the change of the size's factor.
constexpr int kTagUnknowns = 7;
using TagRow = Eigen::Matrix<double, 1, kTagUnknowns>;

/// The tag as one camera sees it.
struct TagCamera {
  CameraModel model;
  Eigen::Isometry3d X_CL = Eigen::Isometry3d::Identity();
};

/// Image of the point `p_T` (m) of the tag's plane, with its derivative by the unknowns. False behind the camera.
bool project(const TagCamera& camera, const TagPlacement& tag, const Eigen::Vector2d& p_T, Eigen::Vector2d& pixel,
             Eigen::Matrix<double, 2, kTagUnknowns>& J);

/// One side of the black square in an image: by how far, along the normal, the edge lies outside the predicted one. A
/// line is fitted to the displacements; its value at the middle and its slope towards the end are uncorrelated.
struct TagSide {
  std::array<double, 2> displacement_px{};  ///< at the middle; from the middle to the end
  std::array<double, 2> variance_px2{};
  std::array<TagRow, 2> J{};  ///< their derivatives by the unknowns
  Eigen::Vector2d normal{0, 0};
};

enum class EdgeFault {
  kNone,
  kCutOff,       ///< a part of the tag or of its white margin is outside the window
  kTooSmall,     ///< a cell covers too few pixels
  kLowContrast,  ///< black and white are too similar
  kBlurred,      ///< the edges are wider than a cell
  kNotStraight,  ///< something covers a part of the border, or it is not flat
};

/// What the edges of the black square say about a predicted pose.
struct TagEdges {
  EdgeFault fault = EdgeFault::kNone;
  std::array<TagSide, 4> sides;  ///< side k is from corner k to the next one
};

/// Measures the four sides of a tag of side `size_m` in the part `window` of an 8-bit BGR image, near where `tag`
/// predicts them. An edge is where the area under the brightness profile across it puts a step: unbiased for any
/// symmetric blur that is narrower than a cell. The variance comes from the scatter along the side; `sigma_px` is the
/// standard deviation of additional error of every image point.
TagEdges measure_edges(const TagCamera& camera, const TagPlacement& tag, double size_m, const cv::Mat& bgr,
                       const cv::Rect& window, double sigma_px);

}  // namespace multireach::vision
