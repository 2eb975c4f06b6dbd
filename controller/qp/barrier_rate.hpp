#pragma once

namespace multireach::controller {

/// How fast a joint may approach its limit, as a fraction of its distance from the limit per step: `rate` in continuous
/// time, `slope` for discrete steps.
struct BarrierRate {
  explicit BarrierRate(double per_step) : rate(per_step), slope(per_step / (1 + per_step)) {}
  double rate, slope;
};

}  // namespace multireach::controller
