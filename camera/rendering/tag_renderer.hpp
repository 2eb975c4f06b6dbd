#pragma once

#include "camera/rendering/ball_renderer.hpp"

namespace multireach {

/// A printed AprilTag of the family 36h11 with its white margin.
struct TagLook {
  int id = 0;            ///< 0 to 586
  double size_m = 0.06;  ///< side of the black square
};

/// A flat card printed in square cells, black and white.
struct Card {
  cv::Mat1b cells;    ///< 1 is white; the first is at the left top
  double cell_m = 0;  ///< side of a cell
};

/// A chessboard with so many inner corners, and a white margin of one square.
Card chessboard_card(int columns, int rows, double square_m);

/// Renders the image of one camera of a rig: a tag or another card, lit and matt, in front of the wall of
/// `BallRenderer`. Every pixel that the tag touches is averaged over 64 rays through the lens model, whose positions
/// are evenly spread along both axes, so that also an edge along a row or column is drawn to a 64th of a pixel. The
/// cells come from the AprilTag library. The same seed and stream give the same pixels.
class TagRenderer {
 public:
  /// As for BallRenderer. Throws std::invalid_argument for an id that the family does not have.
  TagRenderer(const SceneOptions& scene, const TagLook& tag, const CameraModel& camera, const Eigen::Isometry3d& X_WC,
              const Eigen::Isometry3d& X_WL);

  TagRenderer(const SceneOptions& scene, const Card& card, const CameraModel& camera, const Eigen::Isometry3d& X_WC,
              const Eigen::Isometry3d& X_WL);

  /// An 8-bit BGR image with the tag at `X_WT` (tag's frame: x right, y down, z into the paper), or without a tag.
  /// `motion_W`: how far it moves during the exposure, m; half-way it is at `X_WT`.
  cv::Mat render(const std::optional<Eigen::Isometry3d>& X_WT, uint64_t stream,
                 const Eigen::Vector3d& motion_W = Eigen::Vector3d::Zero()) const;
  /// The same before noise, for several images of a tag at rest: three floats a pixel.
  cv::Mat exposed(const std::optional<Eigen::Isometry3d>& X_WT) const;
  /// The 8-bit image that the camera makes of it.
  cv::Mat developed(const cv::Mat& exposed, uint64_t stream) const { return background_.developed(exposed, stream); }

 private:
  cv::Point cell_at(const Eigen::Isometry3d& X_TC, const Eigen::Vector3d& ray) const;
  void draw(const Eigen::Isometry3d& X_CT, cv::Mat& image) const;

  CameraModel camera_;
  Eigen::Isometry3d X_CW_;
  Eigen::Vector3d light_W_;
  BallRenderer background_;
  Card card_;
};

}  // namespace multireach
