#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace multireach::vision {

/// Morphological opening of a mask by a cross of five pixels, row by row: what remains are the pixels of all such
/// crosses that lie in the mask. So specks and bridges of less than three pixels go. Outside of the mask nothing is
/// set. A row is one bit per pixel, in words as class_bits() writes them. Keeps its memory.
class RowOpening {
 public:
  /// How many rows later a row comes out.
  static constexpr int kDelay = 2;

  /// Begins a mask whose rows have so many words.
  void begin(size_t words);
  /// The next row's words, to be filled; stays until advance().
  uint64_t* next();
  /// Takes the row that was filled and returns the row kDelay before, opened; null when nothing of it remains or it is
  /// before the first. `any`: whether the filled row has a bit; one without need not be filled.
  const uint64_t* advance(bool any);

 private:
  struct Row {
    std::vector<uint64_t> words;  // with a zero before and behind
    bool any = false;
  };
  Row& raw(int back) { return raw_[static_cast<size_t>((at_ + 3 - back) % 3)]; }
  Row& eroded(int back) { return eroded_[static_cast<size_t>((at_ + 3 - back) % 3)]; }

  size_t words_ = 0;
  int at_ = 0;
  std::array<Row, 3> raw_, eroded_;  // by row modulo 3
  std::vector<uint64_t> opened_;
};

}  // namespace multireach::vision
