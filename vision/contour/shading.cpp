#include "vision/contour/shading.hpp"

#include <Eigen/Cholesky>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/contour/shading.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "numeric/wide_lanes-inl.hpp"

namespace multireach::vision {
/// Of each term, the sums over the points of its product with every number.
using ShadingSums = std::array<SurfaceColour, Shading::kTerms>;
}  // namespace multireach::vision

HWY_BEFORE_NAMESPACE();
namespace multireach::vision {
namespace HWY_NAMESPACE {

using multireach::HWY_NAMESPACE::kWidth;
using multireach::HWY_NAMESPACE::Lanes;
using multireach::HWY_NAMESPACE::LanesTag;
namespace hn = hwy::HWY_NAMESPACE;

void add_up(std::span<const SurfaceColour> points, ShadingSums& sums) {
  const LanesTag lanes;
  constexpr int kParts = (SurfaceColour::kNumbers + kWidth - 1) / kWidth;
  std::array<std::array<Lanes, kParts>, Shading::kTerms> total;
  for (auto& of_term : total) of_term.fill(0.0);
  for (const SurfaceColour& point : points) {
    for (int part = 0; part < kParts; ++part) {
      const Lanes numbers = hn::Load(lanes, point.numbers.data() + part * kWidth);
      for (size_t term = 0; term < total.size(); ++term) total[term][part] += Lanes(point.numbers[term]) * numbers;
    }
  }
  for (size_t term = 0; term < total.size(); ++term) {
    for (int part = 0; part < kParts; ++part)
      hn::Store(total[term][part].v, lanes, sums[term].numbers.data() + part * kWidth);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach::vision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace multireach::vision {

HWY_EXPORT(add_up);

void Shading::clear() {
  terms_.setZero();
  covariance_.setZero();
  known_ = false;
}

void Shading::fit(std::span<const SurfaceColour> points) {
  ShadingSums sums;
  HWY_DYNAMIC_DISPATCH(add_up)(points, sums);
  Matrix normal_equations;
  Eigen::Matrix<double, kTerms, 3> products;
  for (int term = 0; term < kTerms; ++term) {
    const SurfaceColour& of_term = sums[static_cast<size_t>(term)];
    normal_equations.col(term) = of_term.terms();
    products.row(term) = of_term.bgr();
  }
  // Ridge penalties: second-order shading terms are weaker than first-order terms, and those than the constant.
  constexpr double kFirst = 0.02, kSecond = 0.5;
  Terms kept_small;
  for (int k = 0; k < kTerms; ++k) kept_small[k] = k == 0 ? 0 : k < 4 ? kFirst : kSecond;
  normal_equations.diagonal() += kept_small;
  const Matrix inverse = normal_equations.ldlt().solve(Matrix::Identity());
  terms_.noalias() = inverse * products;
  // Covariance of a ridge regression: the penalties carry no noise.
  covariance_ = inverse - inverse * kept_small.asDiagonal() * inverse;
  known_ = true;
}

}  // namespace multireach::vision
#endif
