#pragma once

namespace multireach::controller {

/// How fast a joint may approach its limit, as a share of its distance from it: `rate` per step in continuous time,
/// `slope` for steps of one.
struct BarrierRate {
  explicit BarrierRate(double per_step) : rate(per_step), slope(per_step / (1 + per_step)) {}
  double rate, slope;
};

}  // namespace multireach::controller
