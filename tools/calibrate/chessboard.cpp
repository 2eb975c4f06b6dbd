#include "tools/calibrate/chessboard.hpp"

#include <algorithm>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace multireach {
namespace {

/// Distance from corner (column, row) to its nearest neighbour, pixels.
double spacing(const Board& board, const Corners& corners, int column, int row) {
  double nearest = std::numeric_limits<double>::infinity();
  const cv::Point2f& here = corners[static_cast<size_t>(row * board.columns + column)];
  for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
    const int x = column + dx, y = row + dy;
    if (x < 0 || y < 0 || x >= board.columns || y >= board.rows) continue;
    nearest = std::min(nearest, cv::norm(here - corners[static_cast<size_t>(y * board.columns + x)]));
  }
  return nearest;
}

/// Refines each corner from the image gradients around it. The window should be as large as possible to suppress noise,
/// but must not reach the edges of the next corner, so its size is chosen for each corner.
void refine(const cv::Mat& grey, const Board& board, Corners& corners) {
  constexpr double kPart = 0.3;  // of the distance to the next corner; gave the smallest residuals on real boards
  constexpr int kLeast = 2, kMost = 15;
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-4);
  const Corners rough = corners;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const int half = std::clamp(static_cast<int>(kPart * spacing(board, rough, column, row)), kLeast, kMost);
      const auto at = static_cast<size_t>(row * board.columns + column);
      Corners one{rough[at]};
      cv::cornerSubPix(grey, one, {half, half}, {-1, -1}, until);
      corners[at] = one[0];
    }
  }
}

double agreement(const Corners& a, const Corners& b) {
  const auto middle = [](const Corners& corners) {
    cv::Point2f sum(0, 0);
    for (const cv::Point2f& corner : corners) sum += corner;
    return sum / static_cast<float>(corners.size());
  };
  const cv::Point2f ma = middle(a), mb = middle(b);
  double sum = 0;
  for (size_t k = 0; k < a.size(); ++k) sum += (a[k] - ma).dot(b[k] - mb);
  return sum;
}

}  // namespace

std::vector<cv::Point3f> Board::corners() const {
  std::vector<cv::Point3f> points;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column)
      points.emplace_back(static_cast<float>(column * square_m), static_cast<float>(row * square_m), 0.0F);
  }
  return points;
}

std::optional<Corners> find_board(const cv::Mat& grey, const Board& board) {
  // Detection is slow, so it uses a downscaled image; the corners are refined at full resolution.
  constexpr double kSearched = 1000;
  const double scale = std::max(1.0, std::max(grey.cols, grey.rows) / kSearched);
  cv::Mat searched = grey;
  if (scale > 1) cv::resize(grey, searched, {}, 1 / scale, 1 / scale, cv::INTER_AREA);
  Corners corners;
  const bool found = cv::findChessboardCorners(searched, board.size(), corners,
                                               cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE) ||
                     cv::findChessboardCornersSB(searched, board.size(), corners, cv::CALIB_CB_NORMALIZE_IMAGE);
  if (!found) return std::nullopt;
  const auto enlarged = [](float at, double factor) { return static_cast<float>((at + 0.5) * factor - 0.5); };
  const double across = static_cast<double>(grey.cols) / searched.cols,
               down = static_cast<double>(grey.rows) / searched.rows;
  for (cv::Point2f& corner : corners) corner = {enlarged(corner.x, across), enlarged(corner.y, down)};
  refine(grey, board, corners);
  return corners;
}

std::optional<cv::Size> find_board_size(const cv::Mat& left, const cv::Mat& right) {
  constexpr int kLeast = 3;
  std::optional<cv::Size> size;
  for (const cv::Mat* grey : {&left, &right}) {
    Corners corners;
    cv::Mat cells;
    if (!cv::findChessboardCornersSB(*grey, {kLeast, kLeast}, corners,
                                     cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_LARGER, cells))
      return std::nullopt;
    const cv::Size found(std::max(cells.cols, cells.rows), std::min(cells.cols, cells.rows));
    if (size && found != *size) return std::nullopt;
    size = found;
  }
  return size;
}

void match_corner_order(const Board& board, const Corners& left, Corners& right) {
  Corners best = right, turned = right;
  // A square board is symmetric under quarter turns, any other board under half turns.
  const bool square = board.rows == board.columns;
  for (int turns = 1; turns < (square ? 4 : 2); ++turns) {
    const Corners before = turned;
    const int n = board.columns;
    for (size_t k = 0; k < turned.size(); ++k) {
      const int row = static_cast<int>(k) / n, column = static_cast<int>(k) % n;
      turned[k] = square ? before[static_cast<size_t>(column * n + n - 1 - row)] : before[before.size() - 1 - k];
    }
    if (agreement(left, turned) > agreement(left, best)) best = turned;
  }
  right = best;
}

}  // namespace multireach
