// Included inside a namespace; see numeric/sine_cosine.inl.hpp. `Scalar` is double for one program, or Lanes for
// several in parallel; results are bit-identical either way.

/// Coherence under joint velocity bounds: the box-constrained quadratic program
///
///   minimise |D^-1/2 (v - wanted)|^2 + gamma |J v - hand|^2   over  lower_i <= v_i <= upper_i,
///
/// Eq. (6) with W_x = I and W_theta^-1 = gamma D; D is diagonal, by default the identity. Where D_i is 0, v_i is
/// wanted_i inside its bounds. With lambda = gamma (hand - J v) the solution is v = clamp(wanted + D J^T lambda), so
/// the M unknowns lambda satisfy a piecewise linear, strongly monotone equation: the stationarity condition of the
/// convex dual cost. Newton's method solves it, starting from the unbounded solution; a line search shortens steps that
/// would overshoot the minimum of the dual. The solution is found when the active set no longer changes. If the
/// iteration limit is reached first, v still is inside the bounds.
template <int M, size_t kCapacity, class Scalar>
struct BoxQp {
  using Task = std::array<Scalar, M>;
  using Joints = std::array<Scalar, kCapacity>;
  using Mask = decltype(Scalar{} < Scalar{});
  static constexpr int kMaxSystems = 60;   // linear systems solved
  static constexpr int kMaxHalvings = 50;  // bisections of one Newton step
  static constexpr std::array<double, kMaxJoints> kEqual = [] {
    std::array<double, kMaxJoints> equal{};
    for (double& element : equal) element = 1;
    return equal;
  }();

  int n;
  Scalar gamma;
  const std::array<Joints, M>& jacobian;
  const Joints& wanted;
  const Task& hand;
  const Joints &lower, &upper;
  const std::array<double, kMaxJoints>& mobility = kEqual;  ///< D, see above

  /// Writes the solutions of the programs in the mask `programs` to `result`; the other lanes of `result` do not
  /// change. `multiplier` is lambda / gamma of the unbounded program. Returns the number of linear systems solved, the
  /// largest over all programs.
  [[gnu::noinline]] int solve(Task multiplier, Mask programs, Joints& result) const {
    Task residual;
    Joints held, v, next_held, next_v;
    velocity(multiplier, residual, held, v);
    for (int systems = 1; systems <= kMaxSystems; ++systems) {
      const Task full = newton(held);
      Task stride, next = full, next_residual;
      for (int m = 0; m < M; ++m) stride[m] = full[m] - multiplier[m];
      const Scalar slope = dot(stride, residual);
      const Mask ended = programs & !(slope > 0);
      take(ended, v, result);
      programs = programs & !ended;
      if (!any(programs)) return systems;
      velocity(next, next_residual, next_held, next_v);
      const Mask cut = programs & differ(next_held, held) & (dot(stride, next_residual) < 0);
      if (any(cut)) shorten(cut, multiplier, stride, slope, next, next_residual, next_held, next_v);
      Mask solved = !differ(next_held, held);
      for (int m = 0; m < M; ++m) solved = solved & (next[m] == full[m]);
      v = next_v;
      take(programs & solved, v, result);
      programs = programs & !solved;
      if (!any(programs)) return systems;
      multiplier = next;
      residual = next_residual;
      held = next_held;
    }
    take(programs, v, result);
    return kMaxSystems;
  }

 private:
  static Scalar dot(const Task& a, const Task& b) {
    Scalar sum = 0;
    for (int m = 0; m < M; ++m) sum += a[m] * b[m];
    return sum;
  }

  void take(Mask programs, const Joints& from, Joints& to) const {
    for (int i = 0; i < n; ++i) to[i] = where(programs, from[i], to[i]);
  }

  Mask differ(const Joints& a, const Joints& b) const {
    Mask same = a[0] == b[0];
    for (int i = 1; i < n; ++i) same = same & (a[i] == b[i]);
    return !same;
  }

  /// Line search by bisection, for the programs in `cut`: shortens the step to just before the minimum of the dual.
  [[gnu::noinline]] void shorten(Mask cut, const Task& multiplier, const Task& stride, Scalar slope, Task& next,
                                 Task& next_residual, Joints& next_held, Joints& next_v) const {
    Scalar below = 0, above = 1;
    for (int k = 0; k < kMaxHalvings && any(cut); ++k) {
      const Scalar middle = 0.5 * (below + above);
      Task tried, tried_residual;
      Joints tried_held, tried_v;
      for (int m = 0; m < M; ++m) tried[m] = multiplier[m] + middle * stride[m];
      velocity(tried, tried_residual, tried_held, tried_v);
      const Scalar left = dot(stride, tried_residual);
      for (int m = 0; m < M; ++m) {
        next[m] = where(cut, tried[m], next[m]);
        next_residual[m] = where(cut, tried_residual[m], next_residual[m]);
      }
      take(cut, tried_held, next_held);
      take(cut, tried_v, next_v);
      const Mask over = left < 0;
      above = where(over, middle, above);
      below = where(over, below, middle);
      cut = cut & !((left >= 0) & (left <= 0.5 * slope));
    }
  }

  /// Computes for a multiplier: v; the residual hand - J v - multiplier (the descent direction of the dual, divided by
  /// gamma); and the active bound of each joint in `held`: -1 lower (also when both bounds are equal), 1 upper, 0 none.
  void velocity(const Task& multiplier, Task& residual, Joints& held, Joints& v) const {
    for (int m = 0; m < M; ++m) residual[m] = hand[m] - multiplier[m];
    for (int i = 0; i < n; ++i) {
      Scalar pull = 0;
      for (int m = 0; m < M; ++m) pull += jacobian[m][i] * multiplier[m];
      const Scalar u = wanted[i] + gamma * (pull * mobility[i]);
      v[i] = clamped(u, lower[i], upper[i]);
      held[i] = where((u < lower[i]) | (lower[i] == upper[i]), -1, where(u > upper[i], 1, 0));
      for (int m = 0; m < M; ++m) residual[m] -= jacobian[m][i] * v[i];
    }
  }

  /// The multiplier that solves the program for this active set.
  Task newton(const Joints& held) const {
    typename SmallSolve<M, Scalar>::Matrix A;
    Task b = hand;
    for (int r = 0; r < M; ++r) {
      for (int c = 0; c <= r; ++c) A[r][c] = r == c ? 1 : 0;
    }
    for (int i = 0; i < n; ++i) {
      const Mask free = held[i] == 0;
      const Scalar fixed = where(held[i] < 0, lower[i], where(held[i] > 0, upper[i], wanted[i]));
      for (int r = 0; r < M; ++r) {
        b[r] -= jacobian[r][i] * fixed;
        for (int c = 0; c <= r; ++c) A[r][c] += where(free, gamma * (jacobian[r][i] * mobility[i]) * jacobian[c][i], 0);
      }
    }
    return SmallSolve<M, Scalar>(A).solve(b);
  }
};
