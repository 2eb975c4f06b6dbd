#include "vision/contour/contour_edgel.hpp"

#include <cmath>
#include <numbers>

namespace multireach::vision {

void place_edgels(const ContourPolygon& polygon, double radius_px, int most, std::vector<ContourEdgel>& edgels) {
  edgels.clear();
  const int stride = 1 + static_cast<int>(4 * std::numbers::sqrt2 * radius_px / most);
  double area = 0;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector2d &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    area += a.x() * b.y() - a.y() * b.x();
  }
  const int turn = area > 0 ? 1 : -1;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector2d a = polygon[k], d = polygon[(k + 1) % polygon.size()] - a;
    // Along rows where the contour is steep, along columns where it is flat.
    const bool along_row = std::abs(d.y()) >= std::abs(d.x());
    const double from = along_row ? a.y() : a.x(), way = along_row ? d.y() : d.x();
    const double start = along_row ? a.x() : a.y(), slope = (along_row ? d.x() : d.y()) / way;
    const int step = way > 0 ? stride : -stride;
    // The lines in (from, from + way], in order along the contour.
    int line = static_cast<int>(way > 0 ? std::floor(from) + 1 : std::ceil(from) - 1);
    while (line % stride != 0) line += way > 0 ? 1 : -1;
    for (; way > 0 ? line <= from + way : line >= from + way; line += step) {
      ContourEdgel edgel;
      edgel.edge = {.along_row = along_row,
                    .line = line,
                    .at = start + (line - from) * slope,
                    .outward = (way > 0 ? 1 : -1) * (along_row ? turn : -turn),
                    .cosine = 1 / std::sqrt(1 + slope * slope)};
      edgel.edge.normal = turn * Eigen::Vector2d(d.y(), -d.x()) / d.norm();
      edgel.part = k;
      edgel.length = stride / edgel.edge.cosine;
      edgel.profile = edgels.size();
      if (edgel.profile < kMaxContourPoints) edgels.push_back(edgel);
    }
  }
}

}  // namespace multireach::vision
