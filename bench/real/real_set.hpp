#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "imaging/stereo_rig.hpp"

namespace multireach::bench {

/// A labelled object in a real video: where its centre is in each labelled image. Several objects that look alike share
/// a name; an image then has several points.
struct LabelledObject {
  std::string name;
  std::map<size_t, std::vector<cv::Point2d>> centres;  ///< by the image's number
  std::vector<size_t> clicks;                          ///< numbers of the images to learn the colour from; may be empty
  size_t targets = 1;  ///< how many of those that look alike are tracked: as many targets of the same colours
};

/// A point in both images of a pair, pixels.
struct StereoPoint {
  cv::Point2d left, right;
};

/// A labelled object in a real video of two cameras.
struct StereoObject {
  std::string name;
  std::map<size_t, StereoPoint> centres;  ///< by the image's number
  std::map<size_t, StereoPoint> clicks;   ///< points on it, to learn its colours from
};

/// An object in a real stereo pair with true disparities.
struct StillObject {
  /// A point on it.
  struct Click {
    cv::Point left_px;
    double disparity_px = 0;  ///< between the images' columns
    cv::Point right_px() const { return {cvRound(left_px.x - disparity_px), left_px.y}; }
  };
  /// Pixels of disparity: what differs by less from the click is taken for the same object.
  static constexpr double kSameObject_px = 4;

  std::string name;
  Click click;
  cv::Rect region;                 ///< encloses it in the left image
  bool whole = true;               ///< both images show all of it
  double least_m = 0, most_m = 0;  ///< 5 % and 95 % of the true depths of its visible surface
};

/// An object in a real stereo pair, whose position was measured by other means, as with a tape.
struct MeasuredObject {
  cv::Point2d left_px, right_px;  ///< its centre, by hand
  Eigen::Vector3d p_W;            ///< m
};

/// Reads an image of the camera. Throws InputError, also where it has another size.
cv::Mat read_image_of(const CameraModel& camera, const std::string& path);

/// Columns by which second_image() is wider.
inline constexpr int kAddedColumns = 1;

/// Replaces the image of a second camera: the first camera's image with kAddedColumns repeated at the left, because
/// vision refuses two images that are the same. It is not shifted, which would cut objects off.
cv::Mat second_image(const cv::Mat& image);

/// Real data in one folder, as set.yaml in it describes (docs/real-images.md).
struct RealSet {
  std::string name;
  bool for_test = false;  ///< no constant was chosen on it
  StereoRig rig;
  // A video with labelled centres. Where there are `stereo` objects, the second camera's images are `right_images`,
  // else second_image() of the first's: `rig` then has principal points that differ by the disparity.
  std::vector<std::string> images, right_images;
  std::vector<StereoObject> stereo;
  std::vector<LabelledObject> labelled;
  double frames_per_s = 30;
  // A stereo pair, with true disparities or with measured positions.
  cv::Mat left, right;
  cv::Mat true_disparity_px;       ///< of the left image's pixels, between the images' columns; -1: not known
  double disparity_offset_px = 0;  ///< columns cut off between the images: added to disparities for depths
  std::vector<StillObject> still;
  std::vector<MeasuredObject> measured;  ///< they look alike
  cv::Mat learn_left, learn_right;       ///< to learn their colours from
  double radius_m = 0;                   ///< of theirs; 0: not known

  /// Throws InputError.
  static RealSet load(const std::string& folder);
};

}  // namespace multireach::bench
