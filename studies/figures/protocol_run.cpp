#include "studies/figures/protocol_run.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <functional>

#include "controller/ik/multi_start.hpp"
#include "controller/law/paper_law.hpp"
#include "controller/reach_controller.hpp"
#include "studies/figures/law_run.hpp"

namespace multireach {
namespace {

using namespace controller;

constexpr int kStepsPerTick = static_cast<int>(kStepsPerSecond * kProtocolTick + 0.5);

/// The paper's gamma, 350 rad^2/m^2 for an arm of 0.217 m, scaled to this arm's reach: gamma * reach^2 stays the same.
PaperParameters paper_parameters(const Chain& chain) {
  const double ratio = 0.217 / chain.reach();
  return {.gains = {}, .gamma = 350 * ratio * ratio};
}

int64_t microseconds(double seconds) {
  return std::llround(seconds * 1e6);
}

/// Calls `tick` once per tick with the new target (null when unchanged), until it returns joint positions that are not
/// finite.
ProtocolRun ticks(const Chain& chain, const JointVector& start, const std::vector<ProtocolTarget>& targets,
                  double seconds, const std::function<JointVector(const ProtocolTarget*, double now)>& tick) {
  ProtocolRun run;
  append_setpoint(run.motion, kProtocolTick, start, chain.position(start));
  size_t next = 0;
  for (int k = 0; k * kProtocolTick < seconds; ++k) {
    const double now = k * kProtocolTick;
    const ProtocolTarget* fresh = nullptr;
    for (; next < targets.size() && targets[next].time_s <= now + 1e-9; ++next) fresh = &targets[next];
    const JointVector theta = tick(fresh, now);
    run.finite = theta.allFinite();
    if (!run.finite) break;
    append_setpoint(run.motion, kProtocolTick, theta, chain.position(theta));
  }
  return run;
}

ProtocolRun run_controller(const Chain& chain, ReachOptions options, const JointVector& start,
                           const std::vector<ProtocolTarget>& targets, double seconds) {
  options.lost_after_us = microseconds(seconds) + 1;
  options.ticks = TickTimes::kPeriodic;  // as all controllers that are compared
  ReachController controller(chain, options);
  controller.start(start);
  controller.restart_grid(0);
  return ticks(chain, start, targets, seconds, [&](const ProtocolTarget* fresh, double) {
    if (fresh) {
      controller.observe({.utime = microseconds(fresh->time_s),
                          .seen = true,
                          .position = fresh->position,
                          .velocity = fresh->velocity,
                          .covariance = Eigen::Matrix3d::Zero()});
    }
    return controller.tick().theta;
  });
}

/// A target that moves with its velocity in every integration step.
struct MovingTarget {
  Eigen::Vector3d position, velocity;  // velocity per step
  void set(const ProtocolTarget& fresh, double now) {
    velocity = fresh.velocity / kStepsPerSecond;
    position = fresh.position + fresh.velocity * (now - fresh.time_s);
  }
};

ProtocolRun run_literal(const Chain& chain, const JointVector& start, const std::vector<ProtocolTarget>& targets,
                        double seconds) {
  const PaperParameters paper = paper_parameters(chain);
  PaperState state = paper_state_at_rest(chain, start, start);
  MovingTarget target{chain.position(start), Eigen::Vector3d::Zero()};
  bool chosen = false;
  return ticks(chain, start, targets, seconds, [&](const ProtocolTarget* fresh, double now) {
    if (fresh) target.set(*fresh, now);
    if (fresh && !chosen) {
      state.theta_target = MultiStartIk(chain).best({.position = target.position}, start).theta;
      chosen = true;
    }
    for (int step = 0; step < kStepsPerTick && chosen; ++step) {
      paper_step(chain, paper, target.position, target.velocity, state);
      target.position += target.velocity;
    }
    return state.theta;
  });
}

ProtocolRun run_damped(const Chain& chain, const JointVector& start, const std::vector<ProtocolTarget>& targets,
                       double seconds) {
  constexpr double kGain = 0.03;     // per step: gives the same distance after 1.2 s as the critically damped attractor
  constexpr double kDamping = 0.05;  // fraction of the reach
  const double damping2 = std::pow(kDamping * chain.reach(), 2);
  JointVector theta = start;
  MovingTarget target{chain.position(start), Eigen::Vector3d::Zero()};
  return ticks(chain, start, targets, seconds, [&](const ProtocolTarget* fresh, double now) {
    if (fresh) target.set(*fresh, now);
    for (int step = 0; step < kStepsPerTick; ++step) {
      Eigen::Vector3d x;
      PositionJacobian J;
      chain.position_and_jacobian(theta, x, J);
      const Eigen::Vector3d wanted = kGain * (target.position - x) + target.velocity;
      const Eigen::Matrix3d A = J * J.transpose() + damping2 * Eigen::Matrix3d::Identity();
      const JointVector velocity = J.transpose() * A.llt().solve(wanted);
      const JointVector fastest = chain.velocity() / kStepsPerSecond;
      theta = chain.clamped(theta + velocity.cwiseMin(fastest).cwiseMax(-fastest));
      target.position += target.velocity;
    }
    return theta;
  });
}

}  // namespace

ProtocolRun run_protocol(const Chain& chain, ProtocolLaw law, const JointVector& start,
                         const std::vector<ProtocolTarget>& targets, double seconds,
                         const Eigen::Matrix3d& orientation) {
  ReachOptions options;
  // The published protocols have no acceleration limits.
  options.law = GuardedParameters{.acceleration = JointVector::Constant(chain.size(), INFINITY)};
  switch (law) {
    case ProtocolLaw::kPaperLiteral:
      return run_literal(chain, start, targets, seconds);
    case ProtocolLaw::kDampedLeastSquares:
      return run_damped(chain, start, targets, seconds);
    case ProtocolLaw::kPaper:
      options.law = paper_parameters(chain);
      break;
    case ProtocolLaw::kGuardedPose:
      options.task = TaskKind::kPose;
      options.orientation = orientation;
      break;
    case ProtocolLaw::kGuarded:
      break;
  }
  return run_controller(chain, options, start, targets, seconds);
}

}  // namespace multireach
