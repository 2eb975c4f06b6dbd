#pragma once

#include "vision/colour_class.hpp"
#include "vision/segment.hpp"
#include "vision/triangulate.hpp"

namespace multireach::vision {

struct TrackerOptions {
  StereoRig rig;
  ColourClass colour;
  double ball_radius_m = 0;    ///< of a sphere, whose image is not centred on its centre's; 0 where that is not known
  double min_area_px = 30;     ///< smaller blobs are not the object
  double sigma_px = 0.15;      ///< standard deviation of a blob's centroid, per coordinate
  double max_epipolar_px = 3;  ///< the blobs of both images belong together only below this
};

/// What was found in one pair of images.
struct Sighting {
  enum class Status {
    kSeen,
    kWrongImageSize,  ///< an image is not of the size that the calibration is for
    kNotInLeft,       ///< no blob of the colour
    kNotInRight,
    kCutOff,         ///< at the border of an image
    kNotTheSame,     ///< the blobs are not on one epipolar line
    kBehindCameras,  ///< the rays do not meet in front of the cameras
  };
  Status status = Status::kNotInLeft;
  Triangulation point;                            ///< meaningful when seen
  Eigen::Vector2d left_px{0, 0}, right_px{0, 0};  ///< centroids as measured, pixels
};

enum class Side { kLeft, kRight };

/// What one image of a pair shows.
struct View {
  bool fits = false;         ///< the image is of the size and kind that the calibration is for
  std::optional<Blob> blob;  ///< the largest of the colour
};

/// A sentence for people.
const char* description(Sighting::Status status);

/// Finds the coloured object in a stereo pair. The same images give the same answer.
class StereoTracker {
 public:
  /// Throws std::invalid_argument for options that make no sense: no reference colour, cameras without size or focal
  /// length, no baseline, a right camera that is not to the right of the left one.
  explicit StereoTracker(const TrackerOptions& options);

  const TrackerOptions& options() const { return options_; }
  /// What one 8-bit BGR image shows. Both sides may be looked at at the same time.
  View look(Side side, const cv::Mat& bgr);
  /// Where that is.
  Sighting find(const View& left, const View& right) const;
  Sighting find(const cv::Mat& left_bgr, const cv::Mat& right_bgr) {
    const View left = look(Side::kLeft, left_bgr);
    return find(left, look(Side::kRight, right_bgr));
  }

 private:
  std::optional<Triangulation> locate(const Blob& left, const Blob& right) const;

  TrackerOptions options_;
  ColourTable table_;
  cv::Mat left_mask_, right_mask_;
};

}  // namespace multireach::vision
