#include "tools/calibrate/board_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <set>

#include "runtime/files.hpp"
#include "runtime/image_file.hpp"

namespace multireach {
namespace {

cv::Mat grey_image(const std::string& path) {
  cv::Mat grey;
  cv::cvtColor(read_image(path), grey, cv::COLOR_BGR2GRAY);
  return grey;
}

cv::Size common_size(const BoardImages& images) {
  const std::string& first = images.left_files[0];
  const cv::Size size = read_image(first).size();
  for (const auto* files : {&images.left_files, &images.right_files}) {
    for (const std::string& file : *files) {
      const cv::Mat image = read_image(file);
      if (image.size() == size) continue;
      throw InputError(fmt::format("{}: is {} x {} pixels and {} is {} x {}; a calibration needs images of one size",
                                   file, image.cols, image.rows, first, size.width, size.height));
    }
  }
  return size;
}

/// The last number in a file name, without leading zeros; "" if there is none.
std::string number_of(const std::string& path) {
  const std::string name = std::filesystem::path(path).stem().string();
  const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  const auto end = std::find_if(name.rbegin(), name.rend(), digit).base();
  auto begin = std::find_if_not(std::make_reverse_iterator(end), name.rend(), digit).base();
  while (begin != end && *begin == '0') ++begin;
  return {begin, end};
}

}  // namespace

BoardImages find_boards(const std::string& left_pattern, const std::string& right_pattern, const Board& board,
                        const std::function<void(double)>& progress) {
  BoardImages images;
  images.left_files = matching_files("--left", left_pattern);
  images.right_files = matching_files("--right", right_pattern);
  const size_t count = images.left_files.size();
  if (count != images.right_files.size()) {
    throw InputError(
        fmt::format("--left has {} files and --right {}; they must be pairs", count, images.right_files.size()));
  }
  // Report unusable input before the slow search.
  images.size = common_size(images);
  for (size_t k = 0; k < count; ++k) {
    const std::string &left = images.left_files[k], &right = images.right_files[k];
    if (left == right) throw InputError(left + ": is named for both cameras");
    if (number_of(left) != number_of(right))
      images.warnings.push_back(left + " and " + right + ": are taken as a pair, but their numbers differ");
  }
  for (size_t k = 0; k < count; ++k) {
    const std::string &left = images.left_files[k], &right = images.right_files[k];
    progress(static_cast<double>(k) / static_cast<double>(count));
    const auto l = find_board(grey_image(left), board);
    const auto r = find_board(grey_image(right), board);
    for (const auto& [found, path] : {std::pair(&l, &left), std::pair(&r, &right)}) {
      if (!*found)
        images.warnings.push_back(
            fmt::format("{}: no board of {}x{} inner corners is seen as a whole", *path, board.columns, board.rows));
    }
    if (!l || !r) continue;
    images.pair_index.push_back(k);
    images.pairs.push_back({*l, *r});
    match_corner_order(board, images.pairs.back().left, images.pairs.back().right);
  }
  return images;
}

std::set<int> covered_fields(const std::vector<Corners>& corners, cv::Size image_size) {
  constexpr int kColumns = kFieldColumns, kRows = kFieldRows;
  std::set<int> fields;
  for (const Corners& list : corners) {
    for (const cv::Point2f& corner : list) {
      const int column =
          std::clamp(static_cast<int>(corner.x * kColumns / static_cast<float>(image_size.width)), 0, kColumns - 1);
      const int row =
          std::clamp(static_cast<int>(corner.y * kRows / static_cast<float>(image_size.height)), 0, kRows - 1);
      fields.insert(row * kColumns + column);
    }
  }
  return fields;
}

double coverage(const std::vector<Corners>& corners, cv::Size image_size) {
  return static_cast<double>(covered_fields(corners, image_size).size()) / (kFieldColumns * kFieldRows);
}

}  // namespace multireach
