#pragma once

#include "kinematics/chain.hpp"
#include "tools/figures/table.hpp"

namespace multireach {

/// What docs/guarantees.md shows, one scene for each promise. Times are nominal, s; everything else SI.

/// A reach in which the law `paper` passes a joint limit: that joint under both laws.
Table limits_scene(const Chain& chain);
/// A reach in which the law `paper` is trapped: distance of the hand under both, and gamma.
Table arrival_scene(const Chain& chain);
/// From stretched down to stretched sideways (Hoap2).
Table singularity_scene(const Chain& chain);
/// A target that rests, moves, jumps, trembles, is lost, returns, and leaves the reach (Hoap2).
Table targets_scene(const Chain& chain);
/// A target that moves on until another posture is clearly nearer (Hoap2).
Table posture_choice_scene(const Chain& chain);
/// Someone holds the arm away from where it is commanded to be, for a second (Hoap2).
Table push_scene(const Chain& chain);
/// A wall in the way (Hoap2).
Table obstacle_scene(const Chain& chain);
/// Reaches among 12 random obstacles, between postures that are clear of them: one row for each.
Table clutter_scene(const Chain& chain);
/// A target with an orientation, and one with a pointing direction; for arms of 6 joints or more.
Table orientation_scene(const Chain& chain);

}  // namespace multireach
