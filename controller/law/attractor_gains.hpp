#pragma once

#include "controller/law/vite.hpp"

namespace multireach::controller {

/// Steps per second for which the guarded law's gains and constants per step are given: the paper's "roughly 7
/// milliseconds".
inline constexpr double kReferenceRate = 140;

/// The motion of an attractor, at any integration rate: r'' = w^2 (r_T - r) - 2 z w r' with the natural frequency w in
/// rad/s and the damping ratio z. It does not overshoot when z >= 1. It comes within 1 % of a resting target after 6.6
/// / w seconds where z = 1.
struct AttractorMotion {
  double natural_frequency;
  double damping_ratio;
};

/// The gains per step that give this motion; the poles of the discrete attractor are those of the continuous one after
/// a step. Requires a positive frequency and damping ratio >= 1.
ViteGains vite_gains(const AttractorMotion& motion, double steps_per_second);
/// The motion of an attractor that does not overshoot with these gains per step; alpha < 1.
AttractorMotion attractor_motion(const ViteGains& gains, double steps_per_second);

/// Converts gains per step of 1 / `from` s, with which an attractor does not overshoot, into gains per step of 1 / `to`
/// s with which it moves alike. Unchanged when both rates are equal.
ViteGains gains_at_rate(const ViteGains& gains, double from, double to);

}  // namespace multireach::controller
