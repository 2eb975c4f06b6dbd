#pragma once

#include <Eigen/Geometry>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "imaging/camera_model.hpp"
#include "imaging/rgb.hpp"

namespace multireach {

/// The scene, apart from the ball's position.
struct SceneOptions {
  uint64_t seed = 1;
  double ball_radius_m = 0.02;
  Rgb ball_colour{220, 40, 110};
  double wall_distance_m = 0.9;  ///< of the textured wall behind the ball, along the left camera's axis
  int distractors = 12;          ///< coloured discs on the wall
  double noise_grey_levels = 2;  ///< standard deviation of the sensor noise, per channel
  double wall_grey = 95;         ///< darkest grey level of the wall
  double wall_contrast = 1;      ///< contrast of the wall's texture
  double wall_fineness = 1;      ///< fineness of the wall's texture: 2 halves the size of its patches
  int rays_per_side = 4;         ///< subpixel rays per side of a pixel on the ball's contour (antialiasing)
  /// The camera's grey levels are the light to the power of 1 / gamma, as most cameras' with 2.2 (IEC 61966-2-1). All
  /// colours here are grey levels that the camera shows; noise is added to grey levels.
  double gamma = 1;
};

/// A card that occludes a part of the ball: parallel to the image, just in front of the ball, with one straight edge
/// across it.
struct Occluder {
  double occlusion = 0.1;  ///< occluded share of the ball's area in the image
  double angle_rad = 0;    ///< direction from the ball's centre to the occluded part, from the image's x to its y axis
  Rgb colour{90, 100, 80};
};

/// A flat disc beside the ball, parallel to the image, at the distance of the ball's centre.
struct Neighbour {
  double angle_rad = 0;  ///< direction from the ball's centre, as above
  double radius_m = 0.02;
  double gap_m = 0;  ///< between both contours; negative: the ball occludes a part of the neighbour
  Rgb colour{200, 90, 60};
};

/// A painted band around the ball: the great circle perpendicular to `axis_W`, and what is near it.
struct Stripe {
  Eigen::Vector3d axis_W{0, 0, 1};  ///< unit vector
  double half_width = 0.15;         ///< share of the ball's radius
  Rgb colour{230, 230, 225};
};

/// What may vary from image to image.
struct ImageConditions {
  double exposure = 1;                       ///< factor on all intensities, before noise and clipping
  std::array<double, 3> gains_rgb{1, 1, 1};  ///< white-balance gains, likewise
  std::optional<Occluder> occluder;
  std::optional<Neighbour> neighbour;
  std::optional<Stripe> stripe{};
  double highlight = 0;               ///< grey levels at the middle of a specular highlight (Blinn-Phong, exponent 60)
  Eigen::Vector3d motion_W{0, 0, 0};  ///< motion of the ball during the exposure, m; half-way it is at `p_WB`
};

/// Renders the image of one camera of a rig: a lit ball in front of a textured wall with coloured discs. The ball's
/// contour is the exact projection of a sphere through the lens model; pixels on it are averaged over a square of rays.
/// The same seed and stream give the same pixels.
class BallRenderer {
 public:
  /// `X_WC`: the camera's pose; `X_WL`: the pose of the rig's left camera, to which the wall is parallel.
  BallRenderer(const SceneOptions& scene, const CameraModel& camera, const Eigen::Isometry3d& X_WC,
               const Eigen::Isometry3d& X_WL);

  /// An 8-bit BGR image with the ball's centre at `p_WB` (m), or without a ball. `stream` selects the noise of the
  /// image. Occluder, neighbour and motion of `look` are drawn only with a ball.
  cv::Mat render(const std::optional<Eigen::Vector3d>& p_WB, uint64_t stream, const ImageConditions& look = {}) const;

  /// The wall without a ball, before noise: three floats per pixel (BGR; grey levels, or with a gamma the light on the
  /// same scale).
  const cv::Mat& wall() const { return wall_; }
  /// The 8-bit image that the camera makes of such an image: with its gains, its noise and clipping.
  cv::Mat developed(const cv::Mat& image, uint64_t stream, const ImageConditions& look = {}) const;
  /// Direction, with z = 1, that the point (right, down) of a pixel sees, each from 0 to 1.
  Eigen::Vector3d ray_in_pixel(int column, int row, double right, double down) const;

 private:
  cv::Vec3f light_of(const Rgb& colour) const;
  std::optional<cv::Vec3f> ball_colour(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& ray,
                                       const ImageConditions& look) const;
  cv::Vec3f wall_colour(const Eigen::Vector3d& origin_L, const Eigen::Vector3d& direction_L) const;
  void draw_ball(const Eigen::Vector3d& p_CB, const ImageConditions& look, cv::Mat& image) const;
  cv::Mat exposed(const Eigen::Vector3d& p_WB, const ImageConditions& look) const;

  struct Disc {
    Eigen::Vector2d centre;
    double radius;
    cv::Vec3f colour;  // light
  };
  SceneOptions scene_;
  CameraModel camera_;
  Eigen::Isometry3d X_CW_;
  Eigen::Vector3d light_C_;
  std::vector<Disc> discs_;
  std::vector<Eigen::Vector2d> corner_rays_;  // rays through the pixels' corners, (width + 1) x (height + 1)
  cv::Mat wall_;                              // CV_32FC3
};

}  // namespace multireach
