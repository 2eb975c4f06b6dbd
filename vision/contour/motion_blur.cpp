#include "vision/contour/motion_blur.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace multireach::vision {

double MotionBlur::length_px() const {
  return std::sqrt(12 * variance);
}

MotionBlur motion_blur_of(std::span<const ContourEdgel> edgels, std::span<const ContourPoint> points) {
  constexpr int kTerms = 5;
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  Eigen::Matrix<double, kTerms, kTerms> A = Eigen::Matrix<double, kTerms, kTerms>::Zero();  // its lower triangle
  Terms b = Terms::Zero();
  for (const ContourEdgel& edgel : edgels) {
    if (edgel.point < 0 || points[static_cast<size_t>(edgel.point)].weight == 0) continue;
    const Eigen::Vector2d& m = edgel.edge.normal;
    Terms terms;
    terms << m.x() * m.x(), 2 * m.x() * m.y(), m.y() * m.y(), m.x(), m.y();
    constexpr double kSharpest = -3, kMost = 8;  // px^2: outliers have little weight
    const double cosine2 = edgel.edge.cosine * edgel.edge.cosine;
    const double blur2 = cosine2 * edgel.blur.colour2;
    for (int column = 0; column < kTerms; ++column) {
      for (int row = column; row < kTerms; ++row) A(row, column) += terms[row] * terms[column];
    }
    b += terms * std::clamp(blur2, kSharpest, kMost);
  }
  constexpr double kRidge = 1;  // edges: where few of them fit, there is no motion
  A.diagonal().array() += kRidge;
  const Terms B = A.ldlt().solve(b);
  const double difference = 0.5 * (B[0] - B[2]), both_sides = 2 * Eigen::Vector2d(difference, B[1]).norm();
  const double one_side = Eigen::Vector2d(B[3], B[4]).norm();
  MotionBlur motion;
  // Motion blurs both ends alike; next to an occluder or a texture one side is blurred.
  motion.variance = std::max(0.0, both_sides - one_side);
  if (motion.variance == 0) return motion;
  // The eigenvector of B's larger eigenvalue, from the row that is further from zero.
  const double half = 0.5 * both_sides;
  motion.along = difference >= 0 ? Eigen::Vector2d(difference + half, B[1]) : Eigen::Vector2d(B[1], half - difference);
  motion.along.normalize();
  return motion;
}

}  // namespace multireach::vision
