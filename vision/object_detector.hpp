#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "vision/camera_check/camera_motion.hpp"
#include "vision/colour/colour_background.hpp"
#include "vision/colour/find.hpp"
#include "vision/colour/illumination.hpp"
#include "vision/contour/sphere_contour.hpp"
#include "vision/track/tracker_options.hpp"
#include "vision/track/view.hpp"

namespace multireach::vision {

/// What was noticed of a camera's motion since the start.
struct CameraShift {
  std::optional<int64_t> last_utime;  ///< when it moved last, microseconds
  Eigen::Vector3d total_px{0, 0, 0};  ///< of the image, as CameraMotion::moved_px(); about
};

/// Detects one object in one camera's images: finds and measures blobs of its colours. Learns from the images what
/// changes slowly: the white balance, where the images show these colours without the object, and whether the camera
/// moves.
class ObjectDetector {
 public:
  ObjectDetector(const TrackerOptions& options, Side side);
  /// Forgets all images.
  void restart();

  cv::Rect whole_image() const { return {0, 0, camera_.width, camera_.height}; }
  /// See search_area() of the options.
  const cv::Rect& search_area() const { return search_area_; }
  /// Whether the next image should be searched in the whole area, to learn the background.
  bool should_search_all() const { return looks_ < kFirstLooks || since_look_ + 1 >= kLookEvery; }
  /// Finds and measures the object's blobs in the part `window` of an 8-bit BGR image. The image must be valid there
  /// and must live as long as the view is used. `chroma_subsampled`: see StereoImages. Blobs that reach into the part
  /// `expected` grow (grow_blobs).
  View measure(const cv::Mat& bgr, const cv::Rect& window, bool chroma_subsampled, Colours colours,
               const cv::Rect& expected = {});

  /// Follows the white balance by the view's blob that shows the object. `quality`: 0 to 1, see adapted().
  void adapt(const View& view, int blob, double quality);
  /// The object was not seen: the white balance returns slowly to what was learned.
  void relax() { gains_ = relaxed(gains_); }
  /// Notices when the camera moves. What was learned of the background is then forgotten, unless it is still about
  /// there. Returns whether the camera has moved.
  bool notice_motion(const View& view, int64_t utime);
  /// Learns where the image shows the target's colours, but for the pixels in the boxes `objects`.
  /// `others_are_background`: false where any of the other blobs may be the target.
  void learn_background(const View& view, std::span<const cv::Rect> objects, bool others_are_background);
  void forget_background(const Blob& blob) { background_.forget(blob); }
  const CameraShift& shift() const { return shift_; }

  const WhiteBalanceGains& gains() const { return gains_; }
  void set_gains(const WhiteBalanceGains& gains) { gains_ = gains; }
  /// The serialized state. Does not contain the gains, which a tracker's state has at its end, nor shift(), which is
  /// for people.
  size_t serialized_size() const;
  void append_serialized(std::vector<double>& state) const;
  /// Whether `state` is what append_serialized() appends.
  [[nodiscard]] bool is_valid_state(std::span<const double> state) const;
  /// Restores a state that is_valid_state() accepts.
  void deserialize(std::span<const double> state);

 private:
  static constexpr int kMaxBlobs = 6;     // measured per image
  static constexpr int kFirstLooks = 16;  // search areas that are searched first to learn the background
  static constexpr int kLookEvery = 8;    // pairs between two searches of a whole area for the background
  static constexpr size_t kLooks = 2;     // numbers of looks in the state
  void grow(const cv::Rect& expected, bool chroma_subsampled, View& view);
  bool learned_colours_show_more(const View& view, const Blob& blob);

  CameraModel camera_;
  cv::Rect search_area_;
  double min_area_px_;
  Eigen::Matrix2d additional_ray_covariance_;  // of TrackerOptions::sigma_px, as ray_covariance()
  ColourTable learned_;                        // without white-balance gains
  AdaptedColourModel model_, wider_;
  WhiteBalanceGains gains_;
  BlobFinder finder_;
  SphereContourFitter fitter_;
  ColourBackground background_;
  CameraMotion motion_;
  CameraShift shift_;   // no state: for people
  int looks_ = 0;       // at the search area, up to the number that suffices to begin with
  int since_look_ = 0;  // pairs
};

}  // namespace multireach::vision
