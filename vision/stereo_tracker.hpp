#pragma once

#include "vision/colour_class.hpp"
#include "vision/segment.hpp"
#include "vision/stereo_sighting.hpp"

namespace multireach::vision {

struct TrackerOptions {
  StereoRig rig;
  ColourClass colour;
  double ball_radius_m = 0;    ///< of a sphere, whose image is not centred on its centre's; 0 where that is not known
  double min_area_px = 30;     ///< smaller blobs are not the object
  double sigma_px = 0.15;      ///< standard deviation of a blob's centroid, per coordinate
  double max_epipolar_px = 3;  ///< the blobs of both images belong together only below this
};

enum class Side { kLeft, kRight };

/// What one image of a pair shows.
struct View {
  bool fits = false;                 ///< the image is of the size and kind that the calibration is for
  std::optional<OutlinedBlob> blob;  ///< the largest of the colour
};

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
  std::optional<Triangulation> locate(const OutlinedBlob& left, const OutlinedBlob& right) const;

  TrackerOptions options_;
  ColourTable table_;
  cv::Mat left_mask_, right_mask_;
};

}  // namespace multireach::vision
