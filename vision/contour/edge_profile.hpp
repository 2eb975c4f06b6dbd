#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <opencv2/core.hpp>

namespace multireach::vision {

/// Where to look for the outline of a sphere: on a row or a column of pixels, near a place, and which way is out.
struct EdgeSite {
  bool along_row = true;         ///< the edge is crossed along a row; else along a column
  int line = 0;                  ///< that row or column
  double at = 0;                 ///< expected column or row of the edge, pixels
  int outward = 1;               ///< +1 when the object is on the side of the smaller coordinates, -1 else
  double cosine = 1;             ///< of the angle between the line and the edge's normal
  Eigen::Vector2d normal{1, 0};  ///< of the edge, outwards, in pixels' axes, of unit length
};

/// The pixels about a site, from inside to outside.
struct EdgeProfile {
  static constexpr int kReach = 6;  ///< pixels on each side of the middle one
  int middle = 0;                   ///< column or row of the middle pixel
  std::array<Eigen::Vector3d, 2 * kReach + 1> bgr;

  const Eigen::Vector3d& at(int outwards) const { return bgr[static_cast<size_t>(kReach + outwards)]; }
};

/// Reads the pixels about a site of an 8-bit BGR image; false when some are outside the image.
bool read_profile(const cv::Mat& image, const EdgeSite& site, EdgeProfile& profile);

/// What is known of all edges of one outline.
struct EdgeModel {
  static constexpr int kSide = 3;  ///< pixels next to the window that tell the colour of each side
  int half = 2;                    ///< the window is 2 half + 1 pixels wide, at most 7
  double noise = 2;                ///< standard deviation of a pixel's independent noise, grey levels
  double radius_px = 1e3;          ///< of the disc
  double outside_slope2 = 0;       ///< variance of the background's slope, grey levels^2 per pixel^2
  double blur2 = -1;               ///< variance of the light's spread across the edges, px^2; negative: not known
  double chroma_error = 0;         ///< how far the hue next to an edge may be wrong, of the difference of both sides
  double shading_error = 0.15;  ///< how far the object's brightness at its rim may be from the one expected, relative
};

/// The direction of a lit sphere's surface in the camera's axes, at a pixel of a profile: of the part of the pixel that
/// is inside the outline.
Eigen::Vector3d surface_normal(const EdgeProfile& profile, const EdgeSite& site, double radius_px, int outwards);

/// How the object's colour changes with the direction of its surface: second-order polynomials of the normal, which
/// hold any distant light on a matt surface to about a hundredth (Ramamoorthi & Hanrahan, SIGGRAPH 2001), fitted to
/// what is inside the outline.
class Shading {
 public:
  static constexpr int kTerms = 9;
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  using Matrix = Eigen::Matrix<double, kTerms, kTerms>;
  static Terms terms_of(const Eigen::Vector3d& normal);

  void clear();
  /// Takes the colour of a place on the surface.
  void add(const Eigen::Vector3d& normal, const Eigen::Vector3d& bgr);
  /// After all were added; the strength of what few places tell is kept small.
  void solve();
  bool known() const { return known_; }
  /// The colour for a sum of terms; zero before `solve`.
  Eigen::Vector3d colour(const Terms& terms) const { return terms_.transpose().lazyProduct(terms); }
  /// Its variance in each channel for places whose colours have the variance 1.
  double variance(const Terms& terms) const { return terms.dot(covariance_.lazyProduct(terms)); }
  /// The covariance of the terms of each channel, likewise.
  const Matrix& covariance() const { return covariance_; }

 private:
  Matrix normal_equations_, covariance_;
  Eigen::Matrix<double, kTerms, 3> products_, terms_;
  bool known_ = false;
};

/// How the background's colour changes per pixel, from the pixels outside of the window.
Eigen::Vector3d outside_slope(const EdgeProfile& profile, const EdgeModel& model);

/// An edge as measured.
struct Edge {
  double at = 0;          ///< column or row
  double sigma_px = 0;    ///< standard deviation of `at` from what differs from edge to edge: noise, texture
  double shading_px = 0;  ///< standard deviation from what shading is in truth, which neighbouring edges share
  /// By how much `at` changes with the fitted shading, whose noise all edges share: gain . (colour of these terms).
  Shading::Terms shading_terms = Shading::Terms::Zero();
  Eigen::Vector3d shading_gain{0, 0, 0};
};

/// How the light of an edge is spread beyond the pixels' own width: variances across the edge, px^2, from one edge and
/// so noisy.
struct EdgeBlur {
  double colour2 = 0;     ///< along the difference of both colours
  double luma2 = 0;       ///< of the brightness alone: less where an image's hues were stored at a lower resolution
  double luma_share = 0;  ///< of the difference of both colours; `luma2` is meaningful only when it is not small
};
EdgeBlur blur_of(const EdgeProfile& profile, const EdgeSite& site, const EdgeModel& model);

/// Measures an edge by the partial-area principle: the share of the object's colour in the pixels across the edge,
/// added up, is the length of the object's part. Unbiased for pixels that average over their area and for any symmetric
/// blur narrower than the window. Where the blur is known (`model.blur2`), least squares then fit the shares of an edge
/// of that blur to the pixels that it touches, which leaves out the noise of the others. The colours of both sides are
/// those next to the window, carried on to the edge with the slopes that are given; they are compared along the
/// direction in colour space that tells them best when the object's brightness at the rim is less sure than its hue.
/// False when there is no edge near the expected place.
bool measure_edge(const EdgeProfile& profile, const EdgeSite& site, const EdgeModel& model, const Shading& shading,
                  Edge& edge);

/// The noise of an image, from the second differences of neighbouring pixels inside the object.
class NoiseGauge {
 public:
  void add(const EdgeProfile& profile);
  /// Standard deviation in grey levels, from the median; at least that of rounding.
  double sigma() const;

 private:
  std::array<int, 128> counts_{};
  int total_ = 0;
};

}  // namespace multireach::vision
