#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace multireach {

/// A chessboard, by its inner corners: those where four squares meet.
struct Board {
  int columns = 9, rows = 6;
  double square_m = 0.025;  ///< side of a square

  cv::Size size() const { return {columns, rows}; }
  /// Its corners in its own frame, m, row by row; z = 0.
  std::vector<cv::Point3f> corners() const;
};

using Corners = std::vector<cv::Point2f>;

/// The board's corners in a grey image, pixels, row by row, to a fraction of a pixel; nothing where it is not seen as a
/// whole. Which of its ends comes first may differ from image to image.
std::optional<Corners> find_board(const cv::Mat& grey, const Board& board);

/// Counts the corners of the right image as those of the left one are counted. For cameras that stand upright to each
/// other: the board's corners lie in about the same directions from its middle in both images.
void count_alike(const Board& board, const Corners& left, Corners& right);

}  // namespace multireach
