#include "vision/colour/find.hpp"

#include <algorithm>
#include <bit>

#include "vision/colour/colour_mask.hpp"

namespace multireach::vision {
namespace {

/// Sum of the squares of 0, 1, ..., n - 1.
int64_t squares_below(int64_t n) {
  return (n - 1) * n * (2 * n - 1) / 6;
}

}  // namespace

void BlobFinder::Sums::add(const Run& run) {
  const int64_t length = run.end - run.begin, columns = length * (run.begin + run.end - 1) / 2, at = run.row;
  if (area == 0) {
    *this = {.left = run.begin, .top = run.row, .right = run.end, .bottom = run.row + 1};
  } else {
    left = std::min(left, run.begin);
    right = std::max(right, run.end);
    top = std::min(top, run.row);
    bottom = std::max(bottom, run.row + 1);
  }
  area += length;
  x += columns;
  y += length * at;
  xx += squares_below(run.end) - squares_below(run.begin);
  xy += columns * at;
  yy += length * at * at;
}

void BlobFinder::Sums::add(const Sums& other) {
  area += other.area;
  x += other.x;
  y += other.y;
  xx += other.xx;
  xy += other.xy;
  yy += other.yy;
  left = std::min(left, other.left);
  right = std::max(right, other.right);
  top = std::min(top, other.top);
  bottom = std::max(bottom, other.bottom);
}

void BlobFinder::cut_row(const uint64_t* bits, int row, int width) {
  uint64_t before = 0;  // last pixel of the previous word, in the lowest bit
  bool open = false;
  for (size_t k = 0; k < words_for(width); ++k) {
    const uint64_t word = bits[k];
    uint64_t edges = word ^ (word << 1 | before);
    before = word >> 63;
    for (; edges != 0; edges &= edges - 1) {
      const int column = static_cast<int>(64 * k) + std::countr_zero(edges);
      if (open) {
        runs_.back().end = column;
      } else {
        runs_.push_back({row, column, width});
      }
      open = !open;
    }
  }
}

uint32_t BlobFinder::root_of(uint32_t label) {
  while (parent_[label] != label) label = parent_[label] = parent_[parent_[label]];
  return label;
}

void BlobFinder::join(uint32_t a, uint32_t b) {
  a = root_of(a);
  b = root_of(b);
  // Keep the older label, so that the root of a component is the label of its first run.
  if (a < b) parent_[b] = a;
  if (b < a) parent_[a] = b;
}

void BlobFinder::connect_row(size_t above, size_t row) {
  const size_t last_above = row;
  for (size_t i = row; i < runs_.size(); ++i) {
    const Run& run = runs_[i];
    while (above < last_above && runs_[above].end < run.begin) ++above;
    bool labelled = false;
    for (size_t k = above; k < last_above && runs_[k].begin <= run.end; ++k) {
      if (labelled) {
        join(label_[i], label_[k]);
      } else {
        label_.push_back(label_[k]);
        labelled = true;
      }
    }
    if (!labelled) {
      const auto label = static_cast<uint32_t>(parent_.size());
      label_.push_back(label);
      parent_.push_back(label);
      sums_.emplace_back();
    }
    sums_[label_[i]].add(run);
  }
}

bool BlobFinder::gather_runs(const cv::Mat& bgr, const cv::Rect& part, const ColourTable& colours, bool opened,
                             int64_t& members) {
  runs_.clear();
  label_.clear();
  parent_.clear();
  sums_.clear();
  const size_t words = words_for(part.width);
  opening_.begin(words);
  size_t above = 0;
  int row_above = -2;
  const auto take = [&](const uint64_t* bits, int row) {
    const size_t begin = runs_.size();
    cut_row(bits, row, part.width);
    if (runs_.size() == begin) return;
    connect_row(row_above == row - 1 ? above : begin, begin);
    above = begin;
    row_above = row;
  };
  for (int row = 0; row < part.height + RowOpening::kDelay && runs_.size() <= kMaxRuns; ++row) {
    uint64_t* bits = opening_.next();
    int here = 0;
    if (row < part.height) {
      here = colour_mask_row(colours, bgr.ptr<uint8_t>(part.y + row) + 3 * static_cast<ptrdiff_t>(part.x), part.width,
                             bits);
      members += here;
    }
    if (!opened) {
      if (here > 0) take(bits, row);
    } else if (const uint64_t* cleaned = opening_.advance(here > 0)) {
      take(cleaned, row - RowOpening::kDelay);
    }
  }
  return runs_.size() <= kMaxRuns;
}

void BlobFinder::rank(const BlobFinderOptions& options) {
  ranked_.clear();
  for (uint32_t label = 0; label < parent_.size(); ++label) {
    const uint32_t root = root_of(label);
    if (root != label) sums_[root].add(sums_[label]);
  }
  for (uint32_t label = 0; label < parent_.size(); ++label) {
    if (parent_[label] == label && static_cast<double>(sums_[label].area) >= options.min_area) ranked_.push_back(label);
  }
  const size_t most = std::min(ranked_.size(), static_cast<size_t>(std::max(options.most, 1)));
  const auto before = [this](uint32_t a, uint32_t b) {
    return sums_[a].area != sums_[b].area ? sums_[a].area > sums_[b].area : a < b;
  };
  std::partial_sort(ranked_.begin(), ranked_.begin() + static_cast<ptrdiff_t>(most), ranked_.end(), before);
  ranked_.resize(most);
}

void BlobFinder::fill_blobs(const cv::Point& corner) {
  if (blobs_.size() < ranked_.size()) blobs_.resize(ranked_.size());
  blob_index_.assign(parent_.size(), -1);
  for (size_t i = 0; i < ranked_.size(); ++i) {
    const Sums& sums = sums_[ranked_[i]];
    Blob& blob = blobs_[i];
    blob_index_[ranked_[i]] = static_cast<int32_t>(i);
    blob.runs.clear();
    blob.box = {sums.left + corner.x, sums.top + corner.y, sums.right - sums.left, sums.bottom - sums.top};
    blob.area = static_cast<double>(sums.area);
    const auto mean = [&](int64_t sum) { return static_cast<double>(sum) / blob.area; };
    const double x = mean(sums.x), y = mean(sums.y), xy = mean(sums.xy) - x * y;
    blob.centroid = {x + corner.x, y + corner.y};
    blob.spread << mean(sums.xx) - x * x, xy, xy, mean(sums.yy) - y * y;
  }
  for (size_t i = 0; i < runs_.size(); ++i) {
    const int32_t blob_index = blob_index_[root_of(label_[i])];
    if (blob_index < 0) continue;
    const Run& run = runs_[i];
    blobs_[static_cast<size_t>(blob_index)].runs.push_back(
        {run.row + corner.y, run.begin + corner.x, run.end + corner.x});
  }
}

FoundBlobs BlobFinder::find(const cv::Mat& bgr, const cv::Rect& part, const ColourTable& colours,
                            const BlobFinderOptions& options) {
  const cv::Rect inside = part & cv::Rect(0, 0, bgr.cols, bgr.rows);
  FoundBlobs found;
  if (bgr.type() != CV_8UC3 || inside.empty()) return found;
  found.too_many_runs = !gather_runs(bgr, inside, colours, options.opened, found.members);
  if (found.too_many_runs) return found;
  rank(options);
  fill_blobs(inside.tl());
  found.blobs = {blobs_.data(), ranked_.size()};
  return found;
}

}  // namespace multireach::vision
