#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/colour/blob.hpp"
#include "vision/contour/edge_profile.hpp"
#include "vision/contour/outline_cone.hpp"

namespace multireach::vision {

/// What one image says about one object: the direction to its centre, its size, and how sure both are.
struct DiscMeasurement {
  enum class Kind {
    kEdges,     ///< the outline of a sphere, fitted to edges measured below the pixel
    kCentroid,  ///< no such outline was found: the middle of the blob, which is much less sure
  };
  Kind kind = Kind::kCentroid;
  /// (x/z, y/z, s) in the camera's frame: direction to the sphere's centre, and s = radius / distance of the centre,
  /// the sine of its angular radius.
  Eigen::Vector3d value{0, 0, 0};
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of `value`, errors of the model included
  Eigen::Vector2d centre_px{0, 0};                       ///< image of the sphere's centre
  double radius_px = 0;                                  ///< about, at the centre
  double outline_seen = 0;                               ///< share of the outline at which an edge was found that fits
  double hidden = 0;       ///< share of the disc's area that something hides or that is outside the image
  double residual_px = 0;  ///< weighted root mean square of the edges' distances from the outline
  double area = 0;         ///< of the blob, pixels
  bool cut_off = false;    ///< a part is outside the image

  Eigen::Vector2d ray() const { return value.head<2>(); }
  Eigen::Matrix2d ray_covariance() const { return covariance.topLeftCorner<2, 2>(); }
};

/// Measures discs in the images of one camera. Keeps nothing from one call to the next but memory.
class DiscMeasurer {
 public:
  /// An outline is believed when at least this share of it is seen: little for what is known to be a sphere, most of it
  /// for what may have any shape.
  static constexpr double kOfASphere = 0.35, kOfAnything = 0.75;

  explicit DiscMeasurer(const CameraModel& camera, double least_seen = kOfASphere)
      : camera_(camera), least_seen_(least_seen) {}

  /// Measures what a blob shows. The blob may be ragged, have holes, be partly hidden or joined to something of a
  /// similar colour: it only tells where to look for the outline. `bgr`: 8-bit, of the camera's size; the blob is not
  /// empty and lies inside it. Always answers; `kind` and `covariance` say how good the answer is.
  DiscMeasurement measure(const cv::Mat& bgr, const Blob& blob);

 private:
  struct Site {
    EdgeSite edge;
    size_t part = 0;     // side of the polygon that it is on
    double length = 0;   // of the outline that it stands for, pixels
    size_t profile = 0;  // in profiles_
    bool readable = false;
    int half = 2;    // of the window, see EdgeModel
    Edge found;      // when there is a point
    int point = -1;  // in points_, or -1: no edge found
  };
  struct Extent {
    int begin, end;  // end <= begin: nothing
  };

  void find_extents(const Blob& blob);
  void find_border_points();
  OutlinePoint outline_point(double x, double y, OutlinePoint::Along along, double sigma_px) const;
  void place_sites(const OutlinePolygon& polygon, double radius_px, int most);
  void measure_sites(const cv::Mat& bgr, bool refined, EdgeModel& model);
  void learn_sides(EdgeModel& model);
  void learn_blur();
  void learn_parts();
  void learn_shading(const EdgeModel& model);
  bool fit_edges(const cv::Mat& bgr, DiscMeasurement& result);
  void describe(const cv::Mat& bgr, const ConeFit& fit, double noise, DiscMeasurement& result);
  Eigen::Matrix3d shading_covariance(const ConeFit& fit, double noise) const;  // of n, from the shading's fit
  double missing_share(const OutlinePolygon& polygon) const;
  double neighbours_agree() const;
  void take_middle(DiscMeasurement& result) const;

  CameraModel camera_;
  double least_seen_;
  cv::Rect box_;                            // of the blob
  std::vector<Extent> rows_, columns_;      // first and last pixel of the blob in each row and column of the box
  Eigen::Vector2d middle_px_, middle_ray_;  // of the box
  Eigen::Matrix2d d_ray_d_pixel_;           // there
  std::vector<Site> sites_;                 // in order along the outline
  std::vector<EdgeProfile> profiles_ = std::vector<EdgeProfile>(kMostOutlinePoints);
  std::vector<OutlinePoint> points_;
  Shading shading_;
  std::array<bool, kOutlineCorners> fits_;  // sides of the polygon where the last fit's edges were
  // Variance of the light's spread across the edges, px^2: along the difference of both colours, and of brightness
  // alone.
  double colour_blur2_ = 0, luma_blur2_ = 0;
  bool hues_blurred_ = false;  // hues were stored at a lower resolution than brightness
  std::vector<double> samples_, wider_samples_;
};

}  // namespace multireach::vision
