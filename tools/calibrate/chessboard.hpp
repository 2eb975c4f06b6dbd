#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace multireach {

/// A chessboard, described by its inner corners, where four squares meet.
struct Board {
  int columns = 9, rows = 6;
  double square_m = 0.025;  ///< side of a square

  cv::Size size() const { return {columns, rows}; }
  /// The corners in the board's frame, m, row by row; z = 0.
  std::vector<cv::Point3f> corners() const;
};

using Corners = std::vector<cv::Point2f>;

/// Finds the board's corners in a grey image with subpixel accuracy, row by row; nothing unless the whole board is
/// visible. Which end of the board comes first may vary between images.
[[nodiscard]] std::optional<Corners> find_board(const cv::Mat& grey, const Board& board);

/// How many inner corners, columns x rows with more columns than rows, the board in a pair of grey images has; nothing
/// where none is found, or where the images show different ones: of a board in part, or at a slant, OpenCV's search may
/// find a smaller grid. The square's side is unknown.
[[nodiscard]] std::optional<cv::Size> find_board_size(const cv::Mat& left, const cv::Mat& right);

/// Reorders the right image's corners to correspond to the left image's. Requires cameras that are upright relative to
/// each other, so that the directions from the board's centre to its corners are similar in both images.
void match_corner_order(const Board& board, const Corners& left, Corners& right);

}  // namespace multireach
