#pragma once

#include <Eigen/Geometry>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "imaging/camera_model.hpp"
#include "imaging/rgb.hpp"

namespace multireach {

/// The scene apart from the ball's place.
struct SceneOptions {
  uint64_t seed = 1;
  double ball_radius_m = 0.02;
  Rgb ball_colour{220, 40, 110};
  double wall_distance_m = 0.9;  ///< of the textured wall behind, from the left camera along its axis
  int distractors = 12;          ///< coloured discs on the wall
  double noise_grey_levels = 2;  ///< standard deviation of the sensor's noise, per channel
  double wall_grey = 95;         ///< darkest of the wall
  double wall_contrast = 1;      ///< of its texture
  double wall_fineness = 1;      ///< of its texture: 2 for patches of half the size
  int rays_per_side = 4;         ///< of a pixel, at the ball's border
};

/// A card that hides a part of the ball. It is parallel to the image, just before the ball; one straight side crosses
/// it.
struct Occluder {
  double hidden = 0.1;   ///< share of the ball's disc
  double angle_rad = 0;  ///< direction from the ball's centre to the hidden part, from the image's x axis to its y axis
  Rgb colour{90, 100, 80};
};

/// A flat disc beside the ball, parallel to the image, at the distance of the ball's centre.
struct Neighbour {
  double angle_rad = 0;  ///< direction from the ball's centre, as above
  double radius_m = 0.02;
  double gap_m = 0;  ///< between both outlines; negative: the ball hides a part of the neighbour
  Rgb colour{200, 90, 60};
};

/// What may differ from image to image.
struct Look {
  double exposure = 1;                       ///< factor of all light, before noise and clipping
  std::array<double, 3> gains_rgb{1, 1, 1};  ///< white balance, likewise
  std::optional<Occluder> occluder;
  std::optional<Neighbour> neighbour;
  Eigen::Vector3d motion_W{0, 0, 0};  ///< of the ball while the shutter is open, m; it is where told half-way
};

/// Renders what one camera of a rig sees: a lit ball before a wall with texture and coloured discs. The ball's outline
/// is the exact image of a sphere through the lens model; border pixels are averaged over a square of rays. The same
/// seed and frame give the same pixels.
class BallRenderer {
 public:
  /// `X_WC`: the camera's pose; `X_WL`: the pose of the rig's left camera, to which the wall is parallel.
  BallRenderer(const SceneOptions& scene, const CameraModel& camera, const Eigen::Isometry3d& X_WC,
               const Eigen::Isometry3d& X_WL);

  /// An 8-bit BGR image with the ball's centre at `p_WB` (m), or without a ball. `stream` tells the noise of one image
  /// from that of another. What `look` adds is drawn only with a ball.
  cv::Mat render(const std::optional<Eigen::Vector3d>& p_WB, uint64_t stream, const Look& look = {}) const;

 private:
  Eigen::Vector3d ray_in_pixel(int column, int row, double right, double down) const;
  std::optional<cv::Vec3f> ball_colour(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& ray) const;
  cv::Vec3f wall_colour(const Eigen::Vector3d& origin_L, const Eigen::Vector3d& direction_L) const;
  void draw_ball(const Eigen::Vector3d& p_CB, const Look& look, cv::Mat& image) const;
  cv::Mat exposed(const Eigen::Vector3d& p_WB, const Look& look) const;

  struct Disc {
    Eigen::Vector2d centre;
    double radius;
    cv::Vec3f colour;
  };
  SceneOptions scene_;
  CameraModel camera_;
  Eigen::Isometry3d X_CW_;
  Eigen::Vector3d light_C_;
  std::vector<Disc> discs_;
  std::vector<Eigen::Vector2d> corner_rays_;  // (width + 1) x (height + 1), at the pixels' corners
  cv::Mat wall_;                              // CV_32FC3
};

}  // namespace multireach
