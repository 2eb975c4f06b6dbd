#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tools/calibrate/stereo_calibration.hpp"

namespace multireach {

/// Pairs of photographs of a chessboard, sorted by name.
struct BoardImages {
  std::vector<std::string> left_files, right_files;  ///< of all pairs
  cv::Size size;                                     ///< of every image
  std::vector<size_t> pair_index;                    ///< indices of the pairs that show the whole board in both images
  std::vector<BoardPair> pairs;                      ///< corners of these pairs
  std::vector<std::string> warnings;                 ///< sentences: images without a board, names that do not match
};

/// Finds the board in all images that the patterns match. Throws InputError when there is none, the numbers of left and
/// right files differ, a file cannot be read, or the image sizes differ. `progress` receives the part done.
BoardImages find_boards(const std::string& left_pattern, const std::string& right_pattern, const Board& board,
                        const std::function<void(double)>& progress);

inline constexpr int kFieldColumns = 8, kFieldRows = 6;
/// Which of 8 x 6 equal fields of the image contain a corner: row * 8 + column.
std::set<int> covered_fields(const std::vector<Corners>& corners, cv::Size image_size);
/// The part of the image covered by corners: the share of these fields.
double coverage(const std::vector<Corners>& corners, cv::Size image_size);

}  // namespace multireach
