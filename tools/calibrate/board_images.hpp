#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/calibrate/stereo_calibration.hpp"

namespace multireach {

/// Pairs of photographs of a board, in the order of their names.
struct BoardImages {
  std::vector<std::string> left_files, right_files;  ///< of all pairs
  cv::Size size;                                     ///< of every image
  std::vector<size_t> shown_in;         ///< the numbers of the pairs that show the whole board in both images
  std::vector<BoardPair> pairs;         ///< their corners
  std::vector<std::string> complaints;  ///< sentences: which images show no board, which names do not match
};

/// Finds the board in all images that the patterns name. Throws InputError when there is none, the numbers of files
/// differ, one cannot be read, or their sizes differ. `progress` is told the part that is done.
BoardImages find_boards(const std::string& left_pattern, const std::string& right_pattern, const Board& board,
                        const std::function<void(double)>& progress);

/// The part of the image over which the corners are spread: of 8 x 6 equal fields, those with a corner in them.
double coverage(const std::vector<Corners>& corners, cv::Size image_size);

}  // namespace multireach
