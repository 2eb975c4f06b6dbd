#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>

#include "vision/contour/shading.hpp"

namespace multireach::vision {

/// The direction of brightness in BGR (Rec. 601), of unit length.
inline Eigen::Vector3d luma_direction() {
  return Eigen::Vector3d(0.114, 0.587, 0.299) / 0.66856;
}

/// Where to measure an edge of a sphere contour: a row or column, the expected position on it and the outward
/// direction.
struct Edgel {
  bool along_row = true;         ///< the profile runs along a row; else along a column
  int line = 0;                  ///< index of that row or column
  double at = 0;                 ///< expected column or row of the edge, pixels
  int outward = 1;               ///< +1 when the object is on the side of smaller coordinates, else -1
  double cosine = 1;             ///< of the angle between the line and the edge's normal
  Eigen::Vector2d normal{1, 0};  ///< outward unit normal of the edge in the image
};

/// The pixels around an edgel, from inside to outside.
struct EdgeProfile {
  static constexpr int kReach = 6;  ///< number of pixels on each side of the middle one
  int middle = 0;                   ///< column or row of the middle pixel
  std::array<cv::Vec3b, 2 * kReach + 1> bgr;

  Eigen::Vector3d at(int outwards) const {
    const cv::Vec3b& pixel = bgr[static_cast<size_t>(kReach + outwards)];
    return {double(pixel[0]), double(pixel[1]), double(pixel[2])};
  }
};

/// Reads the pixels around an edgel of an 8-bit BGR image; false when some are outside of `readable`, a part of the
/// image.
[[nodiscard]] bool read_profile(const cv::Mat& image, const cv::Rect& readable, const Edgel& edgel,
                                EdgeProfile& profile);

/// Parameters common to all edges of one contour.
struct EdgeModel {
  static constexpr int kSide = 3;        ///< pixels on each side of the window that give that side's colour
  static constexpr int kWidestHalf = 3;  ///< a window has 2 half + 1 pixels; half is 1 at least
  static_assert(kWidestHalf + kSide <= EdgeProfile::kReach);
  double noise = 2;             ///< standard deviation of a pixel's independent noise, grey levels
  double radius_px = 1e3;       ///< of the contour
  double outside_slope2 = 0;    ///< variance of the background's slope, grey levels^2 per pixel^2
  double blur2 = -1;            ///< variance of the blur across the edges, px^2; negative: not known
  double chroma_error = 0;      ///< chroma error next to an edge, relative to the colour difference of both sides
  double shading_error = 0.15;  ///< relative error of the object's predicted brightness at its rim
};

/// Slope of the background's colour per pixel, from the pixels outside a window of 2 half + 1 pixels.
Eigen::Vector3d outside_slope(const EdgeProfile& profile, int half);

/// A measured edge.
struct Edge {
  double at = 0;          ///< column or row, pixels
  double sigma_px = 0;    ///< standard deviation of `at` from errors independent between edges: noise, texture
  double shading_px = 0;  ///< standard deviation from errors of the shading model, which neighbouring edges share
  /// Sensitivity of `at` to the fitted shading, whose noise all edges share: gain . (colour of these terms).
  Shading::Terms shading_terms = Shading::Terms::Zero();
  Eigen::Vector3d shading_gain{0, 0, 0};
  /// How far outwards a gamma curve may have moved `at`, pixels: one standard deviation of an error that the edges of
  /// both images share, and of one that those of this image share.
  double gamma_px = 0, gamma_rest_px = 0;
  Eigen::Vector3d rim{0, 0, 0}, background{0, 0, 0};  ///< colours of both sides at the edge, BGR
};

/// Blur of one edge beyond the pixels' own width: variances across the edge, px^2. Noisy, because from a single edge.
struct EdgeBlur {
  double colour2 = 0;     ///< of the colour, along the difference of both sides' colours
  double luma2 = 0;       ///< of the brightness only: smaller where the image has subsampled chroma
  double luma_share = 0;  ///< brightness's share of the colour difference; `luma2` is meaningless when this is small
};

/// Estimates an image's noise from second differences of neighbouring pixels inside the object.
class NoiseEstimator {
 public:
  void add(const EdgeProfile& profile);
  /// Standard deviation in grey levels, from the median; at least the rounding error.
  double sigma() const;

 private:
  std::array<int, 128> counts_{};
  int total_ = 0;
};

}  // namespace multireach::vision
