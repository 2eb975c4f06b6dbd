#pragma once

#include <cstdint>

#include "controller/law/vite.hpp"

namespace multireach::controller {

/// Gains per step of 1/140 s for a target that moves, 28.3 rad/s with damping ratio 1.26: a steady acceleration a
/// leaves an error of a / (alpha beta) steps², a twentieth of that of the default gains. They keep alpha (1 - beta)² >=
/// 4 beta (1 - alpha).
inline constexpr ViteGains kTrackGains{0.4, 0.08};
/// us: from the time that an image was taken to the motion that shows it, beyond the tick itself: some 15 ms for camera
/// and vision, 5 for the bridge's delay, 10 for a robot.
inline constexpr int64_t kTrackPrediction = 30000;
/// s: TargetFilter::Options::acceleration_s. Noise of 0.02 m/s in each observed velocity, 30 times a second, then
/// changes a position that is extrapolated by 80 ms by less than a millimetre.
inline constexpr double kTrackAccelerationTime = 0.1;
/// m^2/s^5: TargetFilter::Options::jerk_noise_m2_s5. A hand that moves by 0.2 m in 0.75 s with minimum jerk (Flash &
/// Hogan, 1985) has a mean squared jerk of 720 (0.2 m)² / (0.75 s)⁶ = 160 m^2/s^6, correlated over some 0.1 s.
inline constexpr double kTrackJerkNoise = 16;

}  // namespace multireach::controller
