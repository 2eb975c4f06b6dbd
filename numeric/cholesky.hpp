#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace multireach {

namespace cholesky {

/// The sum of n numbers, n >= 1, as of two halves.
inline double sum(const double* numbers, int n) {
  return n == 1 ? numbers[0] : sum(numbers, n / 2) + sum(numbers + n / 2, n - n / 2);
}

/// The sum of n numbers, n >= 1, in two lanes for even and odd ones, and the last number where it has no neighbour.
inline double sum_in_lanes(const double* numbers, int n) {
  if (n == 1) return numbers[0];
  std::array<double, 4> even, odd;
  for (int i = 0; i < n / 2; ++i) {
    even[i] = numbers[2 * i];
    odd[i] = numbers[2 * i + 1];
  }
  const double pairs = sum(even.data(), n / 2) + sum(odd.data(), n / 2);
  return n % 2 == 0 ? pairs : pairs + numbers[n - 1];
}

}  // namespace cholesky

/// Solves A y = b for a symmetric positive definite matrix, M at most 8, by Cholesky's factorisation A = L L'. Reads
/// only the lower triangle. It adds in the order of Eigen's A.llt().solve(b) and gives its bits; Eigen's own takes
/// seconds to compile for each M.
template <int M>
Eigen::Matrix<double, M, 1> cholesky_solve(Eigen::Matrix<double, M, M> A, Eigen::Matrix<double, M, 1> b) {
  static_assert(M <= 8);
  for (int k = 0; k < M; ++k) {
    for (int i = k; i < M; ++i) {
      double covered = 0;
      for (int j = 0; j < k; ++j) covered += A(i, j) * A(k, j);
      A(i, k) -= covered;
      A(i, k) = i == k ? std::sqrt(A(k, k)) : A(i, k) / A(k, k);
    }
  }
  std::array<double, M> products;
  for (int i = 0; i < M; ++i) {
    for (int j = 0; j < i; ++j) products[j] = A(i, j) * b[j];
    if (i > 0) b[i] -= cholesky::sum(products.data(), i);
    b[i] /= A(i, i);
  }
  for (int i = M - 1; i >= 0; --i) {
    const int n = M - 1 - i;
    for (int j = 0; j < n; ++j) products[j] = A(i + 1 + j, i) * b[i + 1 + j];
    if (n > 0) b[i] -= cholesky::sum_in_lanes(products.data(), n);
    b[i] /= A(i, i);
  }
  return b;
}

}  // namespace multireach
