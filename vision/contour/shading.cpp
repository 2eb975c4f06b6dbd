#include "vision/contour/shading.hpp"

#include <Eigen/Cholesky>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/contour/shading.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "numeric/wide_lanes-inl.hpp"

namespace multireach::vision {
#if !defined(MULTIREACH_SHADING_SUMS)
#define MULTIREACH_SHADING_SUMS
/// Of each term, the sums over the points of its product with every number.
using ShadingSums = std::array<SurfaceColour, Shading::kTerms>;
#endif
}  // namespace multireach::vision

HWY_BEFORE_NAMESPACE();
namespace multireach::vision {
namespace HWY_NAMESPACE {

using multireach::HWY_NAMESPACE::kWidth;
using multireach::HWY_NAMESPACE::Lanes;

void add_up(std::span<const SurfaceColour> points, ShadingSums& sums) {
  constexpr int kParts = (SurfaceColour::kNumbers + kWidth - 1) / kWidth;
  constexpr int kPartsOfRow = kRowLanes / kWidth;
  std::array<std::array<Lanes, kParts>, Shading::kTerms> total;
  for (auto& of_term : total) of_term.fill(0.0);
  for (const SurfaceColour& point : points) {
    for (int part = 0; part < kParts; ++part) {
      const Lanes numbers =
          multireach::HWY_NAMESPACE::load(point.numbers[part / kPartsOfRow], part % kPartsOfRow * kWidth);
      for (int term = 0; term < Shading::kTerms; ++term) total[term][part] += Lanes(point[term]) * numbers;
    }
  }
  for (int term = 0; term < Shading::kTerms; ++term) {
    for (int part = 0; part < kParts; ++part)
      multireach::HWY_NAMESPACE::store(total[term][part], sums[term].numbers[part / kPartsOfRow],
                                       part % kPartsOfRow * kWidth);
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
