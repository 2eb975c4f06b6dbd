// Included inside a namespace that defines Lanes (one double, or a SIMD vector of them) and the functions on it; see
// numeric/sine_cosine.inl.hpp.

template <class A, class B>
inline auto dot_product(const std::array<A, 3>& a, const std::array<B, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The search of ClosedFormIk::nearest, for one target in each lane.
template <class Lanes>
class ClosedFormSearch {
 public:
  using Vector = std::array<Lanes, 3>;
  using Angles = std::array<Lanes, 4>;

  ClosedFormSearch(const ClosedFormArm& arm, const Vector& x_T, const Angles& theta) : arm_(arm), theta_(theta) {
    for (int k = 0; k < 3; ++k) v_[k] = x_T[k] - arm.shoulder[k];
    v2_ = dot_product(v_, v_);
    on_first_ = dot_product(arm.axis[0], v_);
    v_across_ = across(0, v_);
  }

  /// Writes the nearest IK solution to `posture`. Returns a mask of the lanes that have one.
  auto search(Angles& posture) {
    // |elbow + Rot(axis, angle) forearm|^2 = |v|^2, as radius cos(angle - middle) = C.
    const Lanes C = 0.5 * (v2_ - arm_.elbow2 - arm_.forearm2) - arm_.along;
    const auto reachable = absolute(C) <= arm_.radius + kAtBoundary * v2_;
    const Lanes cosine = clamped(C / arm_.radius, -1, 1);
    const Lanes half = finite_arc_tangent(square_root((1 - cosine) * (1 + cosine)), cosine);
    for (const double sign : {-1.0, 1.0}) {
      Lanes fourth;
      const auto bends = reachable & inside_limits(3, arm_.middle + sign * half, fourth);
      if (!any(bends)) continue;
      const Vector h = forearm_at(fourth);
      for (int k = 0; k < arm_.samples; ++k) {
        const auto& R = arm_.turned[static_cast<size_t>(k)];
        const Vector w{dot_product(R[0], h), dot_product(R[1], h), dot_product(R[2], h)};
        consider(arm_.third(k), fourth, w, bends, 1);
        consider(arm_.third(k), fourth, w, bends, -1);
      }
      const Lanes own = clamped(theta_[2], arm_.third_from, arm_.third_to);
      const Vector w = turned(2, own, h);
      consider(own, fourth, w, bends, 1);
      consider(own, fourth, w, bends, -1);
    }
    const auto found = best_distance_ < kNone;
    if (any(found)) refine();
    posture = best_;
    return found;
  }

 private:
  static constexpr double kAtLimit = 1e-9;      // rad: an angle beyond a limit by less than this is set to the limit
  static constexpr double kAtBoundary = 1e-12;  // relative: a target beyond reach by less than this is at full stretch
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  static constexpr double kTurn = 2 * std::numbers::pi;
  static constexpr int kMaxCuts = 80;  // golden-section cuts; each leaves 0.62 of the bracket

  /// The component of `a` perpendicular to axis i.
  Vector across(int i, const Vector& a) const {
    const auto& axis = arm_.axis[i];
    const Lanes along = dot_product(axis, a);
    return {a[0] - axis[0] * along, a[1] - axis[1] * along, a[2] - axis[2] * along};
  }

  /// `a` rotated about axis i.
  Vector turned(int i, Lanes angle, const Vector& a) const {
    const auto [x, y, z] = arm_.axis[i];
    Lanes s, c;
    sine_and_cosine(angle, s, c);
    const Lanes v = 1 - c;
    return {(c + v * (x * x)) * a[0] + (v * (x * y) - s * z) * a[1] + (v * (x * z) + s * y) * a[2],
            (v * (x * y) + s * z) * a[0] + (c + v * (y * y)) * a[1] + (v * (y * z) - s * x) * a[2],
            (v * (x * z) - s * y) * a[0] + (v * (y * z) + s * x) * a[1] + (c + v * (z * z)) * a[2]};
  }

  Vector forearm_at(Lanes fourth) const {
    Vector h = turned(3, fourth, {arm_.forearm[0], arm_.forearm[1], arm_.forearm[2]});
    for (int k = 0; k < 3; ++k) h[k] = arm_.elbow[k] + h[k];
    return h;
  }

  /// The angle about axis i that turns `from` nearest to `to`, both perpendicular to the axis. Where one of them
  /// vanishes (compared with the squared length `scale2`) any angle will do: then the angle of theta.
  Lanes angle_about(int i, const Vector& from, const Vector& to, Lanes scale2) const {
    constexpr double kSmall2 = 1e-18;
    const Vector cross{from[1] * to[2] - from[2] * to[1], from[2] * to[0] - from[0] * to[2],
                       from[0] * to[1] - from[1] * to[0]};
    const Lanes angle = finite_arc_tangent(dot_product(arm_.axis[i], cross), dot_product(from, to));
    const auto from_on_axis = dot_product(from, from) < kSmall2 * scale2;
    const auto to_on_axis = dot_product(to, to) < kSmall2 * scale2;
    return where(from_on_axis | to_on_axis, theta_[i], angle);
  }

  /// Writes the angle, up to whole turns, that is inside joint i's limits and nearest to theta's angle. Returns a mask
  /// of the lanes that have one.
  auto inside_limits(int i, Lanes angle, Lanes& inside) const {
    const double lower = arm_.lower[i], upper = arm_.upper[i];
    const Lanes turns = rounded_down((theta_[i] - angle) * (1 / kTurn) + 0.5);
    Lanes best = kNone;
    inside = angle;
    for (const double k : {-1.0, 0.0, 1.0}) {
      const Lanes candidate = angle + (turns + k) * kTurn, at = clamped(candidate, lower, upper);
      const Lanes distance = absolute(at - theta_[i]);
      const auto nearer = (candidate >= lower - kAtLimit) & (candidate <= upper + kAtLimit) & (distance < best);
      best = where(nearer, distance, best);
      inside = where(nearer, at, inside);
    }
    return best < kNone;
  }

  /// Computes the IK solution with these third and fourth angles on one of two curves (`side` 1 or -1), and keeps it
  /// where it is the nearest so far. `w` is the tip relative to the shoulder after these two rotations. Returns the
  /// squared distance of the solution from theta.
  template <class Mask>
  Lanes consider(Lanes third, Lanes fourth, const Vector& w, Mask wanted, Lanes side) {
    // z = R2 w = R1^-1 v is the intersection of two cones and a sphere.
    const double c = arm_.cosine12, scale = arm_.inverse_sine12_2;
    const Lanes on_second = dot_product(arm_.axis[1], w);
    const Lanes a = (on_first_ - c * on_second) * scale, b = (on_second - c * on_first_) * scale;
    const Lanes height2 = (v2_ - a * a - b * b - 2 * a * b * c) * scale;
    auto valid = wanted & (height2 >= -kAtBoundary * v2_);
    if (!any(valid)) return kNone;
    const Lanes height = side * square_root(greater(height2, 0));
    Vector z;
    for (int k = 0; k < 3; ++k) z[k] = a * arm_.axis[0][k] + b * arm_.axis[1][k] + height * arm_.across12[k];
    Angles posture{theta_[0], theta_[1], third, fourth};
    valid = valid & inside_limits(1, angle_about(1, across(1, w), across(1, z), v2_), posture[1]);
    if (!any(valid)) return kNone;
    valid = valid & inside_limits(0, angle_about(0, across(0, z), v_across_, v2_), posture[0]);
    Lanes distance = 0;
    for (int i = 0; i < 4; ++i) distance += (posture[i] - theta_[i]) * (posture[i] - theta_[i]);
    distance = where(valid, distance, kNone);
    const auto nearer = distance < best_distance_;
    best_distance_ = where(nearer, distance, best_distance_);
    best_side_ = where(nearer, side, best_side_);
    for (int i = 0; i < 4; ++i) best_[i] = where(nearer, posture[i], best_[i]);
    return distance;
  }

  /// Golden-section search between the neighbours of the best sample, on its curve.
  void refine() {
    constexpr double kRatio = 1 / std::numbers::phi, kNarrow = 1e-9;
    const Lanes fourth = best_[3], side = best_side_;
    const Vector h = forearm_at(fourth);
    auto wanted = best_distance_ < kNone;
    Lanes from = greater(best_[2] - arm_.third_step, arm_.third_from);
    Lanes to = lesser(best_[2] + arm_.third_step, arm_.third_to);
    Lanes left = to - kRatio * (to - from), right = from + kRatio * (to - from);
    Lanes at_left = consider(left, fourth, turned(2, left, h), wanted, side);
    Lanes at_right = consider(right, fourth, turned(2, right, h), wanted, side);
    for (int k = 0; k < kMaxCuts; ++k) {
      wanted = wanted & (to - from > kNarrow);
      if (!any(wanted)) return;
      const auto lower_half = wanted & (at_left < at_right), upper_half = wanted & !(at_left < at_right);
      to = where(lower_half, right, to);
      from = where(upper_half, left, from);
      const Lanes new_left = to - kRatio * (to - from), new_right = from + kRatio * (to - from);
      const Lanes probe = where(lower_half, new_left, new_right);
      const Lanes kept_left = where(upper_half, right, left), kept_right = where(lower_half, left, right);
      const Lanes at_kept_left = where(upper_half, at_right, at_left);
      const Lanes at_kept_right = where(lower_half, at_left, at_right);
      const Lanes at_probe = consider(probe, fourth, turned(2, probe, h), wanted, side);
      left = where(lower_half, probe, kept_left);
      right = where(upper_half, probe, kept_right);
      at_left = where(lower_half, at_probe, at_kept_left);
      at_right = where(upper_half, at_probe, at_kept_right);
    }
  }

  const ClosedFormArm& arm_;
  Angles theta_, best_{};
  Vector v_, v_across_;
  Lanes v2_, on_first_, best_distance_ = kNone, best_side_ = 1;
};
