// The law `paper` for several arms side by side, one in each lane of a register.
#if defined(MULTIREACH_CONTROLLER_PAPER_LANES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MULTIREACH_CONTROLLER_PAPER_LANES_INL_HPP
#undef MULTIREACH_CONTROLLER_PAPER_LANES_INL_HPP
#else
#define MULTIREACH_CONTROLLER_PAPER_LANES_INL_HPP
#endif

#include <numbers>

#include "controller/batch/paper_batch.hpp"
#include "controller/batch/task_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::controller {
namespace HWY_NAMESPACE {

/// N: the number of joints, or 0 for any.
template <int N>
class PaperLanes {
 public:
  /// The arms `first` to first + kWidth - 1 of the block.
  PaperLanes(const PaperPlan& plan, ArmBlock& block, int first) : plan_(plan), block_(block), first_(first) {}

  /// One step. Returns the arms whose theta_T has drifted from the target.
  LanesMask step() {
    const auto [alpha, beta] = plan_.gains;
    Joints theta, wanted, weight, velocity;
    Rows J = rows_of<false>();
    Task hand, target;
    for (int k = 0; k < 3; ++k) {  // (21), (22)
      const Lanes hand_velocity = get(block_.hand_velocity[k]);
      target[k] = get(block_.target[k]);
      hand[k] = hand_velocity + alpha * (-hand_velocity + beta * (target[k] - get(block_.x[k])));
    }
    for (int i = 0; i < n(); ++i) {
      theta[i] = get(block_.joints[i].theta);
      const Lanes before = get(block_.joints[i].velocity);
      wanted[i] = before + alpha * (-before + beta * (get(block_.joints[i].theta_target) - theta[i]));  // (19), (20)
      weight[i] = limit_weight(i, theta[i]);                                                            // (28)
    }
    const Task lambda = weighted(J, weight, wanted, hand);
    for (int i = 0; i < n(); ++i) {
      velocity[i] = wanted[i] + weight[i] * column(J, i, lambda);  // (23)
      theta[i] += velocity[i];                                     // (25)
      store(velocity[i], block_.joints[i].velocity, first_);
      store(theta[i], block_.joints[i].theta, first_);
    }
    for (int m = 0; m < 3; ++m) store(row(J, m, velocity), block_.hand_velocity[m], first_);  // (24)
    place<N, false>(plan_.arm, block_, first_);                                               // (26)

    J = rows_of<true>();  // (27)
    Joints difference;
    for (int i = 0; i < n(); ++i) difference[i] = get(block_.joints[i].theta_target) - theta[i];
    Task lacking;
    for (int m = 0; m < 3; ++m) lacking[m] = row(J, m, difference) + target[m] - get(block_.x_target[m]);
    const Task along = Solve(gram(n(), J)).solve(lacking);
    for (int i = 0; i < n(); ++i) {
      store(get(block_.joints[i].theta_target) + (column(J, i, along) - difference[i]), block_.joints[i].theta_target,
            first_);
    }
    place<N, true>(plan_.arm, block_, first_);
    Task miss;
    for (int m = 0; m < 3; ++m) miss[m] = target[m] - get(block_.x_target[m]);
    const LanesMask near = square_root(dot(miss, miss)) <= plan_.rechoose_m;  // false for what is not a number
    return plan_.rechoose_m == std::numeric_limits<double>::infinity() ? no_lane() : !near;
  }

 private:
  static constexpr size_t kCapacity = kRoom<N>;
  using Joints = HWY_NAMESPACE::Joints<kCapacity>;
  using Rows = HWY_NAMESPACE::Rows<kCapacity>;

  HWY_INLINE int n() const { return N == 0 ? plan_.arm.size : N; }
  HWY_INLINE Lanes get(const Row& row) const { return load(row, first_); }
  template <bool kTarget>
  HWY_INLINE Rows rows_of() const {
    Rows J;
    for (int m = 0; m < 3; ++m) {
      for (int i = 0; i < n(); ++i) {
        J[m][i] = get(kTarget ? block_.joints[i].jacobian_target[m] : block_.joints[i].jacobian[m]);
      }
    }
    return J;
  }
  HWY_INLINE Lanes row(const Rows& J, int m, const Joints& v) const {
    Lanes sum = 0;
    for (int i = 0; i < n(); ++i) sum += J[m][i] * v[i];
    return sum;
  }

  HWY_INLINE Lanes limit_weight(int i, Lanes theta) const {
    const Lanes gamma = get(block_.gamma);
    const double lower = plan_.lower[i], upper = plan_.upper[i];
    if (!plan_.limit_avoidance || lower == -std::numeric_limits<double>::infinity()) return gamma;
    Lanes sine, cosine;
    multireach::HWY_NAMESPACE::sine_and_cosine(2 * std::numbers::pi * (theta - lower) / (upper - lower), sine, cosine);
    return where((theta > lower) & (theta < upper), 0.5 * gamma * (1 - cosine), 0);
  }

  /// The lambda of (I + J W J^T) lambda = hand - J wanted.
  HWY_INLINE Task weighted(const Rows& J, const Joints& weight, const Joints& wanted, const Task& hand) const {
    Solve::Matrix A;
    Task b;
    for (int r = 0; r < 3; ++r) {
      b[r] = hand[r] - row(J, r, wanted);
      for (int c = 0; c <= r; ++c) {
        A[r][c] = r == c ? 1 : 0;
        for (int i = 0; i < n(); ++i) A[r][c] += J[r][i] * weight[i] * J[c][i];
      }
    }
    return Solve(A).solve(b);
  }

  const PaperPlan& plan_;
  ArmBlock& block_;
  int first_;
};

}  // namespace HWY_NAMESPACE
}  // namespace multireach::controller
HWY_AFTER_NAMESPACE();

#endif
