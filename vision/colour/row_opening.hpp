#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace multireach::vision {

/// Morphological opening of a mask by a cross of five pixels, row by row: keeps the pixels of all such crosses that lie
/// in the mask. This removes specks and bridges narrower than three pixels. Pixels outside the image count as not set.
/// A row has one bit per pixel, in words as colour_mask_row() writes them. Reuses its memory.
class RowOpening {
 public:
  /// Delay of the output in rows.
  static constexpr int kDelay = 2;

  /// Starts a mask whose rows have `words` words.
  void begin(size_t words);
  /// Buffer for the next row's words, to be filled; valid until advance().
  uint64_t* next();
  /// Takes the filled row and returns the opened row kDelay rows before it; null when that row is empty or before the
  /// first. `any`: whether the row has a set bit; if not, it need not be filled.
  const uint64_t* advance(bool any);

 private:
  struct Row {
    std::vector<uint64_t> words;  // with a zero word before and after
    bool any = false;
  };
  Row& raw(int back) { return raw_[static_cast<size_t>((at_ + 3 - back) % 3)]; }
  Row& eroded(int back) { return eroded_[static_cast<size_t>((at_ + 3 - back) % 3)]; }

  size_t words_ = 0;
  int at_ = 0;
  std::array<Row, 3> raw_, eroded_;  // ring buffers, indexed by row modulo 3
  std::vector<uint64_t> opened_;
};

}  // namespace multireach::vision
