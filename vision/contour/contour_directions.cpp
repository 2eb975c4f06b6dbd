#include "vision/contour/contour_directions.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/contour/contour_directions.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "numeric/wide_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::vision {
namespace HWY_NAMESPACE {

using multireach::HWY_NAMESPACE::kWidth;
using multireach::HWY_NAMESPACE::Lanes;
using multireach::HWY_NAMESPACE::LanesMask;
using multireach::HWY_NAMESPACE::load;
using multireach::HWY_NAMESPACE::store;

/// Calls `f` with each block of rows and the first of kWidth lanes.
template <class F>
HWY_INLINE void for_lanes(int count, const F& f) {
  for (int block = 0; block * kRowLanes < count; ++block) {
    for (int first = 0; first < kRowLanes; first += kWidth) f(block, first);
  }
}

HWY_INLINE std::array<Lanes, 3> load3(const std::array<PointNumbers, 3>& rows, int block, int first) {
  return {load(rows[0].row(block), first), load(rows[1].row(block), first), load(rows[2].row(block), first)};
}
HWY_INLINE Lanes dot(const std::array<Lanes, 3>& a, const Eigen::Vector3d& n) {
  return a[0] * n[0] + a[1] * n[1] + a[2] * n[2];
}

/// Sets e from x/z and y/z, which are in its first two rows, and its derivatives: along columns for the points of
/// `by_column`, else along rows.
void set_directions(int count, const Eigen::Matrix2d& d_ray_d_pixel, const PointNumbers& by_column,
                    DirectionRows& rows) {
  for_lanes(count, [&](int block, int first) {
    const Lanes x = load(rows.e[0].row(block), first), y = load(rows.e[1].row(block), first);
    const Lanes inverse = 1.0 / square_root(x * x + y * y + 1.0);
    const std::array<Lanes, 3> e = {x * inverse, y * inverse, inverse};
    const auto tangent = [&](int axis) {
      const std::array<double, 3> d = {d_ray_d_pixel(0, axis), d_ray_d_pixel(1, axis), 0};
      const Lanes along = e[0] * d[0] + e[1] * d[1];
      std::array<Lanes, 3> result;
      for (size_t k = 0; k < 3; ++k) result[k] = (d[k] - e[k] * along) * inverse;
      return result;
    };
    const std::array<Lanes, 3> of_row = tangent(0), of_column = tangent(1);
    const LanesMask columns = load(by_column.row(block), first) > 0.5, both = load(rows.normal.row(block), first) > 0.5;
    for (size_t k = 0; k < 3; ++k) {
      store(e[k], rows.e[k].row(block), first);
      store(where(columns, of_column[k], of_row[k]), rows.step[k].row(block), first);
      store(where(both, of_column[k], 0.0), rows.other_step[k].row(block), first);
    }
  });
}

HWY_INLINE void compare_lanes(const DirectionRows& rows, const Eigen::Vector3d& n, int block, int first, Lanes& slope,
                              Lanes& distance) {
  slope = dot(load3(rows.step, block, first), n);
  const LanesMask both = load(rows.normal.row(block), first) > 0.5;
  if (any(both)) {
    const Lanes other = dot(load3(rows.other_step, block, first), n);
    slope = where(both, square_root(slope * slope + other * other), slope);
  }
  // Bounded away from 0: the distance is unbounded where the contour is parallel to the direction of measurement.
  constexpr double kSmallest = 1e-9;
  slope = where(absolute(slope) > kSmallest, slope, with_sign_of(kSmallest, slope));
  distance = (1.0 - dot(load3(rows.e, block, first), n)) / slope;
}

void compare_rows(const DirectionRows& rows, int count, const Eigen::Vector3d& n, PointNumbers& slopes,
                  PointNumbers& distances) {
  for_lanes(count, [&](int block, int first) {
    Lanes slope, distance;
    compare_lanes(rows, n, block, first, slope, distance);
    store(slope, slopes.row(block), first);
    store(distance, distances.row(block), first);
  });
}

double cost_of_rows(const DirectionRows& rows, int count, const Eigen::Vector3d& n, double gate_px, double most) {
  double cost = 0;
  for (int block = 0; block * kRowLanes < count && cost < most; ++block) {
    Row costs;
    for (int first = 0; first < kRowLanes; first += kWidth) {
      Lanes slope, distance;
      compare_lanes(rows, n, block, first, slope, distance);
      const Lanes z = distance / gate_px;
      store(lesser(z * z, 1.0), costs, first);
    }
    for (int lane = 0; lane < kRowLanes && block * kRowLanes + lane < count; ++lane) cost += costs[lane];
  }
  return cost;
}

void weigh_rows(int count, const PointNumbers& residuals_px, const PointNumbers& sigmas_px, const PointNumbers& slopes,
                double reach, double largest_px, PointWeights& weights) {
  for_lanes(count, [&](int block, int first) {
    const Lanes residual = load(residuals_px.row(block), first), sigma = load(sigmas_px.row(block), first);
    const Lanes slope = load(slopes.row(block), first), z = residual / sigma, t = z / reach;
    const Lanes rest = 1.0 - t * t;
    const LanesMask counts = (absolute(t) < 1.0) & (absolute(residual) < largest_px);
    const Lanes weight = where(counts, rest * rest, 0.0), slope2 = slope * slope;
    store(weight, weights.weight.row(block), first);
    store(weight / (slope2 * sigma * sigma), weights.by_sigma.row(block), first);
    store(weight / slope2, weights.by_slope.row(block), first);
    store(weight * weight * z * z, weights.psi2.row(block), first);
    store(rest * (1.0 - 5.0 * t * t), weights.psi_derivative.row(block), first);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach::vision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace multireach::vision {

HWY_EXPORT(set_directions);
HWY_EXPORT(compare_rows);
HWY_EXPORT(cost_of_rows);
HWY_EXPORT(weigh_rows);

void ContourDirections::set(std::span<const ContourPoint> points, const Eigen::Matrix2d& d_ray_d_pixel, int stride) {
  PointNumbers by_column;
  count_ = 0;
  for (size_t i = 0; i < points.size() && count_ < kMaxContourPoints; i += static_cast<size_t>(stride), ++count_) {
    const ContourPoint& point = points[i];
    rows_.e[0][count_] = point.ray.x();
    rows_.e[1][count_] = point.ray.y();
    by_column[count_] = point.along == ContourPoint::Along::kColumn ? 1 : 0;
    rows_.normal[count_] = point.along == ContourPoint::Along::kNormal ? 1 : 0;
  }
  for (int i = count_; i % kRowLanes != 0; ++i) rows_.e[0][i] = rows_.e[1][i] = by_column[i] = rows_.normal[i] = 0;
  HWY_DYNAMIC_DISPATCH(set_directions)(count_, d_ray_d_pixel, by_column, rows_);
}

void ContourDirections::compare(const Eigen::Vector3d& n, PointNumbers& slopes, PointNumbers& distances_px) const {
  HWY_DYNAMIC_DISPATCH(compare_rows)(rows_, count_, n, slopes, distances_px);
}

double ContourDirections::cost(const Eigen::Vector3d& n, double gate_px, double most) const {
  return HWY_DYNAMIC_DISPATCH(cost_of_rows)(rows_, count_, n, gate_px, most);
}

void PointWeights::set(int count, const PointNumbers& residuals_px, const PointNumbers& sigmas_px,
                       const PointNumbers& slopes, double reach, double largest_px) {
  HWY_DYNAMIC_DISPATCH(weigh_rows)(count, residuals_px, sigmas_px, slopes, reach, largest_px, *this);
}

}  // namespace multireach::vision
#endif
