#include "vision/colour/colour_background.hpp"

#include <algorithm>
#include <cstdlib>

namespace multireach::vision {
namespace {

constexpr int kFull = 255;
constexpr int kTimeConstant = 16;  // looks, time constant of a cell
constexpr int kOccupied = 8;       // a cell contains the colour when more than one of this many pixels has it

}  // namespace

ColourBackground::ColourBackground(const cv::Size& image)
    : cell_px_(std::max(1, (image.width + kColumns - 1) / kColumns)),
      columns_((image.width + cell_px_ - 1) / cell_px_),
      rows_((image.height + cell_px_ - 1) / cell_px_),
      level_(static_cast<size_t>(columns_ * rows_), 0),
      pixels_(level_.size(), 0) {}

void ColourBackground::forget() {
  std::ranges::fill(level_, uint8_t{0});
}

/// Calls take(cell, pixels) for the parts of the blob's runs that lie in one cell.
template <typename Take>
void ColourBackground::for_each_cell(const Blob& blob, const Take& take) const {
  for (const Run& run : blob.runs) {
    for (int begin = run.begin; begin < run.end;) {
      const int end = std::min(run.end, (begin / cell_px_ + 1) * cell_px_);
      take(cell_at(begin, run.row), end - begin);
      begin = end;
    }
  }
}

void ColourBackground::forget(const Blob& blob) {
  for_each_cell(blob, [&](size_t cell, int) { level_[cell] = 0; });
}

void ColourBackground::learn(const cv::Rect& window, std::span<const Blob> blobs, std::span<const cv::Rect> objects,
                             int weight) {
  std::ranges::fill(pixels_, 0);
  for (const Blob& blob : blobs) for_each_cell(blob, [&](size_t cell, int pixels) { pixels_[cell] += pixels; });
  const cv::Rect image(0, 0, columns_ * cell_px_, rows_ * cell_px_);
  // The last cells of an image extend beyond it; a window that ends at the border contains them.
  const int right = window.br().x + cell_px_ > image.width ? image.width : window.br().x;
  const int bottom = window.br().y + cell_px_ > image.height ? image.height : window.br().y;
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const cv::Rect cell(column * cell_px_, row * cell_px_, cell_px_, cell_px_);
      if (cell.x < window.x || cell.y < window.y || cell.br().x > right || cell.br().y > bottom) continue;
      if (std::ranges::any_of(objects, [&](const cv::Rect& object) { return !(cell & object).empty(); })) continue;
      const auto k = static_cast<size_t>(row * columns_ + column);
      const int level = level_[k];
      const int wanted = pixels_[k] * kOccupied > cell.area() ? kFull : 0;
      const int step = std::min(std::abs(wanted - level), std::abs(wanted - level) * weight / kTimeConstant + 1);
      level_[k] = static_cast<uint8_t>(wanted > level ? level + step : level - step);
    }
  }
}

double ColourBackground::share_of(const Blob& blob) const {
  int64_t known = 0, all = 0;
  for_each_cell(blob, [&](size_t cell, int pixels) {
    known += int64_t{level_[cell]} * pixels;
    all += pixels;
  });
  return all > 0 ? static_cast<double>(known) / (kFull * static_cast<double>(all)) : 0;
}

}  // namespace multireach::vision
