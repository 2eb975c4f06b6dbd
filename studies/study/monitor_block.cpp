#include "studies/study/monitor_block.hpp"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "studies/study/monitor_block.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "numeric/wide_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach {
namespace HWY_NAMESPACE {

HWY_INLINE Lanes length_of(const std::array<Lanes, 3>& v) {
  return square_root(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

LanesMask update_monitor_lanes(const MonitorConstants& constants, const controller::ArmBlock& block,
                               MonitorBlock& monitor, int first) {
  const ReachRules& rules = constants.rules;
  const Lanes steps = load(monitor.steps, first) + 1;
  Lanes fastest = 0, sum = 0, limit_excess = load(monitor.limit_excess, first);
  Lanes velocity_excess = load(monitor.velocity_excess, first);
  for (size_t i = 0; i < static_cast<size_t>(constants.n); ++i) {
    const Lanes theta = load(block.joints[i].theta, first), speed = absolute(load(block.joints[i].velocity, first));
    fastest = greater(fastest, speed);
    sum += theta + speed;
    limit_excess = greater(greater(limit_excess, theta - constants.upper[i]), constants.lower[i] - theta);
    velocity_excess = greater(velocity_excess, speed * rules.steps_per_second - constants.speed[i]);
  }
  std::array<Lanes, 3> moved, missing;
  for (size_t k = 0; k < 3; ++k) {
    const Lanes x = load(block.x[k], first);
    sum += x;
    moved[k] = x - load(monitor.last_x[k], first);
    missing[k] = x - load(block.target[k], first);
    store(x, monitor.last_x[k], first);
  }
  const LanesMask finite = absolute(sum) <= std::numeric_limits<double>::max();
  const Lanes error = length_of(missing);
  const LanesMask apart = error >= rules.settled_m;
  const Lanes settled = load(monitor.settled_step, first);
  const LanesMask still = fastest < rules.still;
  const Lanes still_steps = where(still, load(monitor.still_steps, first) + 1, 0);
  const LanesMask there = still & (error < 0.1 * rules.arrived_m);
  const LanesMask rests = still_steps > rules.rest_steps;
  store(steps, monitor.steps, first);
  store(limit_excess, monitor.limit_excess, first);
  store(velocity_excess, monitor.velocity_excess, first);
  store(load(monitor.path, first) + length_of(moved), monitor.path, first);
  store(where(finite, error, std::numeric_limits<double>::infinity()), monitor.error, first);
  store(where(finite, 1, 0), monitor.finite, first);
  store(where(apart, -1, where(settled < 0, steps, settled)), monitor.settled_step, first);
  store(still_steps, monitor.still_steps, first);
  return (!finite) | there | rests | !(steps < rules.seconds * rules.steps_per_second);
}

uint32_t update_monitor_block(const MonitorConstants& constants, const controller::ArmBlock& block,
                              MonitorBlock& monitor) {
  uint32_t over = 0;
  for (int first = 0; first < kRowLanes; first += kWidth) {
    over |= bits_of(update_monitor_lanes(constants, block, monitor, first)) << first;
  }
  return over;
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace multireach {

HWY_EXPORT(update_monitor_block);

MonitorConstants::MonitorConstants(const Chain& chain, const ReachRules& reach_rules)
    : n(chain.size()), rules(reach_rules) {
  for (int i = 0; i < n; ++i) {
    lower[static_cast<size_t>(i)] = chain.lower()[i];
    upper[static_cast<size_t>(i)] = chain.upper()[i];
    speed[static_cast<size_t>(i)] = chain.velocity()[i];
  }
}

void MonitorBlock::begin(const controller::ArmBlock& block, int lane) {
  Eigen::Vector3d missing;
  for (int k = 0; k < 3; ++k) {
    const auto axis = static_cast<size_t>(k);
    last_x[axis][lane] = block.x[axis][lane];
    missing[k] = block.x[axis][lane] - block.target[axis][lane];
  }
  for (Row* row : {&steps, &still_steps, &limit_excess, &velocity_excess, &path}) (*row)[lane] = 0;
  settled_step[lane] = -1;
  finite[lane] = 1;
  distance[lane] = error[lane] = multireach::length_of(missing);
}

uint32_t MonitorBlock::update(const MonitorConstants& constants, const controller::ArmBlock& block) {
  return HWY_DYNAMIC_DISPATCH(update_monitor_block)(constants, block, *this);
}

ReachResult MonitorBlock::result(const MonitorConstants& constants, int lane) const {
  ReachResult result;
  result.finite = finite[lane] > 0;
  result.error_m = error[lane];
  result.arrived = result.finite && result.error_m <= constants.rules.arrived_m;
  result.limit_excess = limit_excess[lane];
  result.velocity_excess = velocity_excess[lane];
  result.distance_m = distance[lane];
  result.path_m = path[lane];
  result.steps = static_cast<int64_t>(steps[lane]);
  result.settled_step = static_cast<int64_t>(settled_step[lane]);
  return result;
}

}  // namespace multireach
#endif
