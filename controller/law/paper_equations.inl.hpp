// Included inside a namespace; see numeric/sine_cosine.inl.hpp. Equations of the paper for one arm (`Scalar` is double)
// or for several in parallel (Lanes). Joint vectors have capacity C and use the first n elements.

/// The weight of one joint, Eq. (28), in the unit of `gamma`: see limit_weights in law/paper_equations.hpp.
template <class Scalar>
inline Scalar limit_weight(Scalar theta, double lower, double upper, Scalar gamma) {
  if (lower == -std::numeric_limits<double>::infinity()) return gamma;  // a continuous joint
  Scalar sine, cosine;
  sine_and_cosine(2 * std::numbers::pi * (theta - lower) / (upper - lower), sine, cosine);
  return where((theta > lower) & (theta < upper), 0.5 * gamma * (1 - cosine), 0);
}

/// Row m of J v.
template <size_t C, class Scalar>
inline Scalar row_product(int n, const std::array<std::array<Scalar, C>, 3>& J, int m, const std::array<Scalar, C>& v) {
  Scalar sum = 0;
  for (int i = 0; i < n; ++i) sum += J[m][i] * v[i];
  return sum;
}

/// Element i of J^T y.
template <size_t C, class Scalar>
inline Scalar column_product(const std::array<std::array<Scalar, C>, 3>& J, int i, const std::array<Scalar, 3>& y) {
  Scalar sum = 0;
  for (int m = 0; m < 3; ++m) sum += J[m][i] * y[m];
  return sum;
}

/// Eq. (23) with W_x = I. `velocity`: the joint velocity of the attractor; the coherent one on return.
template <size_t C, class Scalar>
inline void make_coherent(int n, const std::array<std::array<Scalar, C>, 3>& J, const std::array<Scalar, C>& weights,
                          const std::array<Scalar, 3>& hand_velocity, std::array<Scalar, C>& velocity) {
  typename SmallSolve<3, Scalar>::Matrix A;  // (31)
  std::array<Scalar, 3> incoherence;
  for (int r = 0; r < 3; ++r) {
    incoherence[r] = hand_velocity[r] - row_product(n, J, r, velocity);
    for (int c = 0; c <= r; ++c) {
      A[r][c] = r == c ? 1 : 0;
      for (int i = 0; i < n; ++i) A[r][c] += J[r][i] * weights[i] * J[c][i];
    }
  }
  const std::array<Scalar, 3> lambda = SmallSolve<3, Scalar>(A).solve(incoherence);
  for (int i = 0; i < n; ++i) velocity[i] += weights[i] * column_product(J, i, lambda);
}

/// Eq. (27) with tau = 1: writes the increment of theta_T to `update`. J is the Jacobian at theta_T; `missing` is
/// tau x_T' + x_T - K(theta_T).
template <size_t C, class Scalar>
inline void target_update(int n, const std::array<std::array<Scalar, C>, 3>& J, const std::array<Scalar, C>& theta_T,
                          const std::array<Scalar, C>& theta, std::array<Scalar, 3> missing,
                          std::array<Scalar, C>& update) {
  typename SmallSolve<3, Scalar>::Matrix A;
  for (int i = 0; i < n; ++i) update[i] = theta_T[i] - theta[i];
  for (int r = 0; r < 3; ++r) {
    missing[r] = row_product(n, J, r, update) + missing[r];
    for (int c = 0; c <= r; ++c) {
      Scalar sum = 0;
      for (int i = 0; i < n; ++i) sum += J[r][i] * J[c][i];
      A[r][c] = sum;
    }
  }
  const std::array<Scalar, 3> along = SmallSolve<3, Scalar>(A).solve(missing);
  for (int i = 0; i < n; ++i) update[i] = column_product(J, i, along) - update[i];
}
