#include "vision/colour/row_opening.hpp"

namespace multireach::vision {
namespace {

/// Word k of the row shifted by one pixel: each bit is its left, or right, neighbour. The row has a padding word at
/// each end.
inline uint64_t left_of(const uint64_t* words, size_t k) {
  return words[k] << 1 | words[k - 1] >> 63;
}
inline uint64_t right_of(const uint64_t* words, size_t k) {
  return words[k] >> 1 | words[k + 1] << 63;
}

}  // namespace

void RowOpening::begin(size_t words) {
  words_ = words;
  at_ = 0;
  opened_.resize(words);
  for (auto* rows : {&raw_, &eroded_}) {
    for (Row& row : *rows) {
      row.words.assign(words + 2, 0);
      row.any = false;
    }
  }
}

uint64_t* RowOpening::next() {
  return raw(0).words.data() + 1;
}

const uint64_t* RowOpening::advance(bool any) {
  raw(0).any = any;
  // Now the previous row can be eroded and the one before that dilated. Empty rows keep stale words: test `any` before
  // reading them.
  Row& middle = eroded(1);
  middle.any = raw(0).any && raw(1).any && raw(2).any;
  if (middle.any) {
    const uint64_t *above = raw(2).words.data(), *row = raw(1).words.data(), *below = raw(0).words.data();
    uint64_t* out = middle.words.data();
    uint64_t some = 0;
    for (size_t k = 1; k <= words_; ++k) {
      out[k] = row[k] & left_of(row, k) & right_of(row, k) & above[k] & below[k];
      some |= out[k];
    }
    middle.any = some != 0;
  }
  const Row &above = eroded(3), &row = eroded(2), &below = eroded(1);
  const bool remains = above.any || row.any || below.any;
  if (remains) {
    const auto only = [](const Row& from) { return from.any ? ~uint64_t{0} : 0; };
    const uint64_t in_above = only(above), in_row = only(row), in_below = only(below);
    for (size_t k = 1; k <= words_; ++k) {
      const uint64_t* words = row.words.data();
      opened_[k - 1] = (above.words[k] & in_above) | (below.words[k] & in_below) |
                       ((words[k] | left_of(words, k) | right_of(words, k)) & in_row);
    }
  }
  at_ = (at_ + 1) % 3;
  return remains ? opened_.data() : nullptr;
}

}  // namespace multireach::vision
