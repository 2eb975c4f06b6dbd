// Include inside a namespace; see numeric/sine_cosine.inl.hpp.

/// Solves a symmetric positive definite M x M system A y = b by L D L^T factorisation, without square roots; one system
/// per lane. Reads only the lower triangle of A.
template <int M, class Lanes>
class SmallSolve {
 public:
  using Matrix = std::array<std::array<Lanes, M>, M>;
  using Vector = std::array<Lanes, M>;

  explicit SmallSolve(const Matrix& A) {
    for (int j = 0; j < M; ++j) {
      Lanes pivot = A[j][j];
      for (int k = 0; k < j; ++k) pivot -= scaled_[j][k] * L_[j][k];
      inverse_[j] = 1.0 / pivot;
      for (int i = j + 1; i < M; ++i) {
        Lanes entry = A[i][j];
        for (int k = 0; k < j; ++k) entry -= scaled_[i][k] * L_[j][k];
        scaled_[i][j] = entry;
        L_[i][j] = entry * inverse_[j];
      }
    }
  }

  Vector solve(Vector b) const {
    for (int i = 1; i < M; ++i) {
      for (int k = 0; k < i; ++k) b[i] -= L_[i][k] * b[k];
    }
    for (int i = 0; i < M; ++i) b[i] *= inverse_[i];
    for (int i = M - 2; i >= 0; --i) {
      for (int k = i + 1; k < M; ++k) b[i] -= L_[k][i] * b[k];
    }
    return b;
  }

 private:
  Matrix L_, scaled_;  // scaled_ = L D
  Vector inverse_;
};
