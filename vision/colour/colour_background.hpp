#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "vision/colour/blob.hpp"

namespace multireach::vision {

/// Remembers coarsely where one camera's image shows the object's colour all the time although the object is not
/// there: a grid of cells, each with the recent share of looks in which the cell contained that colour. What stands
/// still fills up in about 16 looks; what moves leaves little behind.
class ColourBackground {
 public:
  static constexpr int kColumns = 40;  ///< cells in a row of the image; cells are square
  /// Share of a blob that the background explains, from which on the blob is taken for background.
  static constexpr double kExplained = 0.5;

  explicit ColourBackground(const cv::Size& image);

  void forget();
  /// Forgets what is where a blob is.
  void forget(const Blob& blob);
  /// Learns from the blobs found in `window`; cells that are not completely inside do not change. `weight` is the
  /// number of pairs that this look stands for. Pixels inside `objects` are neither colour nor free of it.
  void learn(const cv::Rect& window, std::span<const Blob> blobs, std::span<const cv::Rect> objects, int weight);
  /// Share of a blob's pixels that the background explains, 0 to 1.
  double share_of(const Blob& blob) const;

  /// The complete state: `cells().size()` numbers of 8 bits.
  std::span<const uint8_t> cells() const { return level_; }
  std::span<uint8_t> cells() { return level_; }

 private:
  size_t cell_at(int column, int row) const {
    return static_cast<size_t>(row / cell_px_ * columns_ + column / cell_px_);
  }
  template <typename Take>
  void for_each_cell(const Blob& blob, const Take& take) const;

  int cell_px_, columns_, rows_;
  std::vector<uint8_t> level_;  // 255 times the share of looks with the colour, by rows
  std::vector<int> pixels_;     // work space of learn()
};

}  // namespace multireach::vision
