#include "vision/colour/join_parts.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <utility>

namespace multireach::vision {
namespace {

// The seams of a basketball are at most 9.5 mm wide, 4 per cent of its diameter (FIBA, Official Basketball Rules:
// Equipment); those of other balls are narrower. The first two of its parts are smaller than the whole.
constexpr double kSeam = 0.05;
constexpr double kMixed = 1;       // pixels on each side of a seam that also show the seam
constexpr double kAlong = 0.6;     // least length of the seam, in diameters of the smaller part
constexpr double kLeastSize = 40;  // pixels, diameter of the object: seams of smaller ones are narrower than two pixels
constexpr double kCompact = 0.7;   // least compactness of the object
constexpr double kDisc = 0.96;     // compactness from which on a blob is a disc, and no part: a square has 0.955

double diameter_of(double area) {
  return 2 * std::sqrt(area / std::numbers::pi);
}

cv::Rect grown(const cv::Rect& box, int by) {
  return {box.x - by, box.y - by, box.width + 2 * by, box.height + 2 * by};
}

/// A run of one of two blobs.
struct PartRun {
  Run run;
  bool of_second;
};

/// The runs of two blobs inside a part of the image, cut to it, ordered by row, then by column.
std::vector<PartRun> runs_inside(const Blob& a, const Blob& b, const cv::Rect& part) {
  std::vector<PartRun> runs;
  for (const Blob* blob : {&a, &b}) {
    for (Run run : blob->runs) {
      run.begin = std::max(run.begin, part.x);
      run.end = std::min(run.end, part.br().x);
      if (run.row >= part.y && run.row < part.br().y && run.begin < run.end) runs.push_back({run, blob == &b});
    }
  }
  std::ranges::sort(runs, {}, [](const PartRun& each) { return std::pair(each.run.row, each.run.begin); });
  return runs;
}

/// In each row in which they face each other across at most `most` pixels, the narrowest gap between two blobs.
std::vector<int> gaps_in_rows(const std::vector<PartRun>& runs, int most) {
  std::vector<int> gaps;
  int counted = -1;
  for (size_t k = 1; k < runs.size(); ++k) {
    const auto &before = runs[k - 1], &here = runs[k];
    const int gap = here.run.begin - before.run.end;
    if (here.run.row != before.run.row || here.of_second == before.of_second || gap > most) continue;
    if (here.run.row == counted) {
      gaps.back() = std::min(gaps.back(), gap);
      continue;
    }
    counted = here.run.row;
    gaps.push_back(gap);
  }
  return gaps;
}

/// The same for the columns of the part.
std::vector<int> gaps_in_columns(const std::vector<PartRun>& runs, const cv::Rect& part, int most) {
  struct Column {
    int row = 0, narrowest = 0;
    bool any = false, of_second = false;
  };
  std::vector<Column> columns(static_cast<size_t>(part.width), Column{.narrowest = most + 1});
  for (const auto& [run, of_second] : runs) {
    for (int x = run.begin - part.x; x < run.end - part.x; ++x) {
      Column& column = columns[static_cast<size_t>(x)];
      if (column.any && column.of_second != of_second)
        column.narrowest = std::min(column.narrowest, run.row - column.row - 1);
      column = {run.row, column.narrowest, true, of_second};
    }
  }
  std::vector<int> gaps;
  for (const Column& column : columns) {
    if (column.narrowest <= most) gaps.push_back(column.narrowest);
  }
  return gaps;
}

double length_of(double x, double y) {
  return std::sqrt(x * x + y * y);
}

/// The length along which two blobs face each other across at most a seam of an object of this area, pixels.
double seam_length(const Blob& a, const Blob& b, double area) {
  const double widest = kSeam * diameter_of(area) + 2 * kMixed;
  // Along the rows or along the columns, or both, a gap is at most twice as wide as across.
  const int most = static_cast<int>(2 * widest);
  const cv::Rect part = grown(a.box, most + 1) & grown(b.box, most + 1);
  if (part.empty()) return 0;
  const std::vector<PartRun> runs = runs_inside(a, b, part);
  const std::vector<int> in_rows = gaps_in_rows(runs, most), in_columns = gaps_in_columns(runs, part, most);
  const double length = length_of(in_rows.size(), in_columns.size());
  if (length == 0) return 0;
  // A gap along an edge that is turned by an angle is as wide as along the rows times the cosine, and as along the
  // columns times the sine: the edge's shares of rows and columns.
  const auto seams = [&](const std::vector<int>& gaps) {
    const double across = static_cast<double>(gaps.size()) / length;
    return std::ranges::count_if(gaps, [&](int gap) { return gap * across <= widest; });
  };
  return length_of(seams(in_rows), seams(in_columns));
}

Blob joined(const Blob& a, const Blob& b) {
  Blob both;
  both.runs.resize(a.runs.size() + b.runs.size());
  std::ranges::merge(
      a.runs, b.runs, both.runs.begin(), {}, [](const Run& run) { return std::pair(run.row, run.begin); },
      [](const Run& run) { return std::pair(run.row, run.begin); });
  both.box = a.box | b.box;
  both.area = a.area + b.area;
  const double share = a.area / both.area;
  const Eigen::Vector2d apart = a.centroid - b.centroid;
  both.centroid = share * a.centroid + (1 - share) * b.centroid;
  both.spread = share * a.spread + (1 - share) * b.spread + share * (1 - share) * apart * apart.transpose();
  return both;
}

/// Takes the first blob out of `left`, and all that seams connect to it, directly or through others.
std::vector<const Blob*> take_group(std::vector<const Blob*>& left) {
  std::vector<const Blob*> group{left.front()};
  double area = left.front()->area;
  left.erase(left.begin());
  const auto belongs = [&](const Blob* other) {
    return std::ranges::any_of(group, [&](const Blob* part) {
      const double along = kAlong * diameter_of(std::min(part->area, other->area));
      return seam_length(*part, *other, area + other->area) >= along;
    });
  };
  for (auto next = left.begin(); next != left.end();) {
    if (!belongs(*next)) {
      ++next;
      continue;
    }
    group.push_back(*next);
    area += (*next)->area;
    left.erase(next);
    next = left.begin();  // of a larger object, wider gaps are seams
  }
  return group;
}

Blob joined(std::span<const Blob* const> parts) {
  Blob whole = *parts.front();
  for (const Blob* part : parts.subspan(1)) whole = joined(whole, *part);
  return whole;
}

/// Leaves out, one after another, the part without which the union of the others is most compact.
void leave_out_others(std::vector<const Blob*>& parts) {
  for (double most = compactness(joined(parts)); parts.size() > 1;) {
    size_t other = parts.size();
    for (size_t k = 0; k < parts.size(); ++k) {
      std::vector<const Blob*> rest = parts;
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
      const double without = compactness(joined(rest));
      if (without <= most) continue;
      most = without;
      other = k;
    }
    if (other == parts.size()) return;
    parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(other));
  }
}

/// Whether parts make an object that is more compact than they are in the mean, or the only one is a disc.
bool make_object(std::span<const Blob* const> parts, const Blob& whole) {
  const double compact = compactness(whole);
  if (parts.size() == 1) return compact >= kDisc;
  double mean = 0;  // by their areas
  for (const Blob* part : parts) mean += part->area / whole.area * compactness(*part);
  return compact >= kCompact && compact > mean && diameter_of(whole.area) >= kLeastSize;
}

/// Adds the objects of a group of blobs that seams connect. Objects beside each other may look like one: of a union,
/// each part may be the object. Where the group makes no object, each blob may be a part of it all.
void add_objects(std::vector<const Blob*> group, std::vector<Blob>& objects) {
  std::vector<const Blob*> parts = group;
  leave_out_others(parts);
  if (const Blob whole = joined(parts); make_object(parts, whole)) {
    objects.push_back(whole);
    for (const Blob* part : parts) {
      if (parts.size() > 1) add_alternative(*part, part->area / whole.area, objects.back());
    }
    std::erase_if(group, [&](const Blob* blob) { return std::ranges::find(parts, blob) != parts.end(); });
    while (!group.empty()) add_objects(take_group(group), objects);
    return;
  }
  const Blob all = joined(group);
  for (const Blob* blob : group) {
    objects.push_back(*blob);
    if (group.size() > 1 && compactness(*blob) < kDisc) add_alternative(all, 1, objects.back());
  }
}

}  // namespace

std::vector<Blob> join_parts(std::span<const Blob> blobs) {
  std::vector<Blob> objects;
  std::vector<const Blob*> left;
  for (const Blob& blob : blobs) left.push_back(&blob);
  while (!left.empty()) add_objects(take_group(left), objects);
  std::ranges::stable_sort(objects, std::greater<>(), &Blob::area);
  return objects;
}

}  // namespace multireach::vision
