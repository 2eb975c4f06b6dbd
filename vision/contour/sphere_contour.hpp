#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "vision/colour/blob.hpp"
#include "vision/contour/blob_centre.hpp"
#include "vision/contour/contour_acceptance.hpp"
#include "vision/contour/contour_cone.hpp"
#include "vision/contour/contour_edgel.hpp"
#include "vision/contour/contour_polygon.hpp"
#include "vision/contour/edge_profile.hpp"
#include "vision/contour/gamma_shift.hpp"
#include "vision/contour/motion_blur.hpp"
#include "vision/contour/shared_errors.hpp"
#include "vision/contour/surface_shading.hpp"

namespace multireach::vision {

/// Measurement of one object in one image: direction to its centre, angular size and their covariance.
struct SphereContour {
  enum class Kind {
    kEdges,     ///< a sphere contour, fitted to edges with subpixel accuracy
    kCentroid,  ///< no such contour was found: the centroid of the blob, which is much less accurate
  };
  Kind kind = Kind::kCentroid;
  /// (x/z, y/z, s) in the camera's frame: direction to the sphere's centre, and s = radius / distance of the centre,
  /// the sine of the angular radius.
  Eigen::Vector3d value{0, 0, 0};
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of `value`, including model errors and `shared`
  SharedErrors shared = SharedErrors::Zero();            ///< the errors that the other image of a pair shares
  /// `value` minus what the blob's centroid gives: 0 where this is what `value` is.
  Eigen::Vector3d from_centroid{0, 0, 0};
  /// Of what the object may be instead of the blob, by adjacent blobs (Blob::alternative_area) and by what may hide a
  /// part of it (BlobCentre::occlusion_covariance): the mean of the outer products of the differences of its direction,
  /// and, by adjacent blobs, its size, as in `value`, or 0. Not in `covariance`. 0 where edges were fitted.
  Eigen::Matrix2d alternative_spread = Eigen::Matrix2d::Zero();
  double alternative_size = 0;
  Eigen::Vector2d centre_px{0, 0};  ///< image of the sphere's centre
  double radius_px = 0;             ///< approximate, in pixels at the image centre
  double visible_fraction = 0;      ///< share of the contour's length with a fitting edge
  static constexpr double kUnknown = -1;
  double occlusion = 0;    ///< share of the area that is occluded or outside the image; kUnknown: not known
  double residual_px = 0;  ///< weighted root mean square of the edges' distances from the contour
  double motion_px = 0;    ///< how far the object moved during the exposure, from the blur of its edges; 0: not known
  double area = 0;         ///< of the blob, pixels
  bool cut_off = false;    ///< a part of the contour, or of what the blob shows, is outside of the readable pixels
  /// Of an arc, of which less than SphereContourFitter::kOfAnything is visible: what the blob's centroid gives instead,
  /// for where the arc's size contradicts the known one; else null.
  std::shared_ptr<SphereContour> by_centroid{};

  Eigen::Vector2d ray() const { return value.head<2>(); }
  Eigen::Matrix2d ray_covariance() const { return covariance.topLeftCorner<2, 2>(); }
  /// Whether it is the centroid of a blob that reaches the border: it may be a part of anything.
  bool is_cut_off_blob() const { return cut_off && kind == Kind::kCentroid; }
};

/// Measures sphere contours in the images of one camera. Calls are independent; only allocated memory is reused.
class SphereContourFitter {
 public:
  /// Smallest visible share of an accepted contour: low for an object known to be a sphere, high for one of unknown
  /// shape. Only the contour within the image counts; of an object of unknown shape, half of all must be visible, too.
  static constexpr double kOfASphere = kSeenOfASphere, kOfAnything = kSeenOfAnything;

  explicit SphereContourFitter(const CameraModel& camera, double least_seen = kOfASphere)
      : camera_(camera), least_seen_(least_seen), gamma_shift_(camera.gamma) {}

  /// Measures the object that a blob shows. The blob may be ragged, have holes, be partly occluded or joined to
  /// something of a similar colour: it only indicates where to look for the contour. `bgr`: 8-bit, of the camera's
  /// size; the blob is not empty and lies inside it. Always returns a result; `kind` and `covariance` give its quality.
  /// Only the pixels in `readable` are read, which contains the blob.
  /// `chroma_subsampled`: the image was encoded with chroma of a lower resolution, as most JPEGs. Where that is not
  /// known, the blur of the edges tells it in three of four images.
  SphereContour fit(const cv::Mat& bgr, const Blob& blob, const cv::Rect& readable, bool chroma_subsampled = false);
  SphereContour fit(const cv::Mat& bgr, const Blob& blob) { return fit(bgr, blob, {0, 0, bgr.cols, bgr.rows}); }

 private:
  /// How far a fit looks for edges, and what it takes for an edge.
  struct Search {
    int reach_px = 0;           ///< edges are looked for this far from the expected position
    double larger_px = 0;       ///< the first cone's radius exceeds that of the blob's border by this
    double usual_blur2 = 0;     ///< prior mean of the blur's variance, px^2
    double small_residual = 0;  ///< a contour whose residual is below this is always accepted, pixels
  };
  static const Search kSharp, kSoft;

  void find_extents(const Blob& blob);
  void find_border_points();
  void add_point(double x, double y, ContourPoint::Along along, double sigma_px);
  void find_rays();
  void clear_points();
  template <class Chosen>
  void choose_edgels(const Chosen& chosen);
  void choose_windows(EdgeModel& model);
  void find_edges(const cv::Mat& bgr, const EdgeModel& model, const Search& search);
  void find_paint(const EdgeModel& model);
  void measure_edgels(const cv::Mat& bgr, bool refined, const Search& search, EdgeModel& model);
  void learn_sides(EdgeModel& model);
  void learn_blur(const Search& search);
  void learn_parts();
  void learn_shading(const EdgeModel& model);
  double painted_share(bool missing) const;
  ContourVerdict fit_edges(const cv::Mat& bgr, const Blob& blob, const Search& search, SphereContour& result);
  /// Returns the share with a fitting edge of the contour's length within the readable pixels.
  double describe(const ConeFit& fit, double noise, SphereContour& result);
  double occluded_fraction(const ContourPolygon& polygon) const;
  void use_centroid(SphereContour& result) const;

  CameraModel camera_;
  double least_seen_;
  GammaShift gamma_shift_;
  cv::Rect readable_;                       // pixels that may be read
  cv::Rect box_;                            // of the blob
  std::vector<BlobExtent> rows_, columns_;  // of the blob, in each row and column of the box
  Eigen::Vector2d middle_px_, middle_ray_;  // of the box
  Eigen::Matrix2d d_ray_d_pixel_;           // at the box's middle
  std::vector<ContourEdgel> edgels_;        // in order along the contour
  std::vector<int> chosen_;                 // indices of edgels
  std::vector<EdgeProfile> profiles_ = std::vector<EdgeProfile>(kMaxContourPoints);
  std::vector<ContourPoint> points_;
  std::vector<Eigen::Vector2d> pixels_, rays_;  // of the points
  std::vector<SurfaceColour> surface_;          // colours that the shading is fitted to
  SurfaceShading shading_;
  std::array<bool, kContourCorners> fits_;  // sides of the polygon where most edges fitted in the last pass
  // Variance of the blur across the edges, px^2: of the colour, and of the brightness only.
  double colour_blur2_ = 0, luma_blur2_ = 0;
  bool chroma_subsampled_ = false;  // known from the image's encoding
  bool hues_blurred_ = false;       // known or measured
  MotionBlur motion_;
  std::vector<double> samples_, wider_samples_;
};

}  // namespace multireach::vision
