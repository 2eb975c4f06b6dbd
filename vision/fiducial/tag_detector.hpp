#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace multireach::vision {

/// A tag as it was found in an image.
struct FoundTag {
  int id = 0;
  /// Corners of the black square, in the order of tag_corner(): pixels, to a sixteenth. A start for the edge
  /// measurement, which is the accurate one.
  std::array<Eigen::Vector2d, 4> corners;
};

/// Number of tags in the family 36h11; ids are 0 to one less.
constexpr int kTagIds = 587;
/// Cells along a side of the black square, its border included. The white margin around it is one more cell.
constexpr int kTagCells = 8;

/// Corner 0 to 3 of the black square of side 1, in the tag's frame T: x to the right of the printed tag, y down, z into
/// the paper, as in the AprilTag library. Lower left, lower right, upper right, upper left.
inline Eigen::Vector2d tag_corner(int k) {
  return {k == 1 || k == 2 ? 0.5 : -0.5, k < 2 ? 0.5 : -0.5};
}

/// Finds AprilTags of the family 36h11 (Olson, "AprilTag: a robust and flexible visual fiducial system", ICRA 2011) by
/// the AprilTag library. At most one wrong bit is corrected. Holds the library's state: one object per thread.
class TagDetector {
 public:
  TagDetector();
  ~TagDetector();
  TagDetector(TagDetector&&) noexcept;
  TagDetector& operator=(TagDetector&&) noexcept;

  /// All tags in the part `window` of an 8-bit BGR image, ordered by id, then by row and column.
  std::vector<FoundTag> find(const cv::Mat& bgr, const cv::Rect& window);

 private:
  struct Library;
  std::unique_ptr<Library> library_;
};

/// The cells of a printed tag, row by row: kTagCells + 2 on a side, the white margin included. 1 is white, 0 black.
cv::Mat1b tag_cells(int id);

}  // namespace multireach::vision
