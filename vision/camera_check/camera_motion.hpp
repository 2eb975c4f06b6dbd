#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace multireach::vision {

/// Tells when a camera moves, from coarse pictures of the whole scene: the mean grey levels of square cells. The motion
/// of the image (shift and turn) since the looks before is fitted to the differences of all cells, with a change of
/// exposure, by the gradient (Lucas and Kanade, An Iterative Image Registration Technique, IJCAI 1981), robustly:
/// people and objects that move are outliers. A shift of less than 1/16 of a cell is not noticed; one of more than an
/// eighth is noticed, but measured as less than it is.
class CameraMotion {
 public:
  static constexpr int kColumns = 20;  ///< cells in a row of the image

  /// `area`: size of the images that look() takes, pixels.
  explicit CameraMotion(const cv::Size& area);

  enum class Motion {
    kNone,
    kSmall,  ///< what was seen in the image before is still about there
    kLarge,  ///< by at least an eighth of a cell
  };

  void forget();
  /// Looks at an image (8-bit BGR). Returns how far the camera has moved since the looks before.
  Motion look(const cv::Mat& bgr);
  /// How the image has moved by the last look, pixels: to the right and down, and by a turn, at half its width from
  /// the middle.
  const Eigen::Vector3d& moved_px() const { return moved_px_; }
  /// Root mean square of such a motion over the image, pixels.
  static double size_px(const Eigen::Vector3d& moved_px);

  /// The complete state: numbers of 8 bits.
  std::span<const uint8_t> cells() const { return before_; }
  std::span<uint8_t> cells() { return before_; }

 private:
  double mean_of(const cv::Mat& bgr, const cv::Rect& part) const;
  Eigen::Vector2d gradient_of(const cv::Mat& bgr, int row, int column) const;
  Motion motion(const cv::Mat& bgr);

  int cell_px_, columns_, rows_;
  std::vector<uint8_t> before_;  // grey levels of the cells, by rows; all 0: nothing was seen yet
  std::vector<uint8_t> now_;     // of the last look
  Eigen::Vector3d moved_px_{0, 0, 0};
};

}  // namespace multireach::vision
