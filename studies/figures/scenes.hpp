#pragma once

#include "kinematics/chain.hpp"
#include "studies/figures/figure.hpp"

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

/// The figures of Hersch & Billard (2008), in their order; see docs/results.md. All but the first are of the Hoap2.

/// Fig. 1: one attractor with several gains.
Figure vite_scene(const SceneArm& arm);
/// Fig. 4: the weight (28) of the last joint over its range and beyond.
Figure weight_scene(const SceneArm& arm);
/// Fig. 7: random reaches that fail, against gamma.
Figure failures_scene(const SceneArm& arm);
/// Fig. 8: the targets that `paper` does not reach.
Figure unreached_scene(const SceneArm& arm);
/// What gamma buys and costs under both laws; not in the paper.
Figure gamma_scene(const SceneArm& arm);
/// Fig. 9: where random reaches come to rest, against theta_T; those off the diagonal, and some on it.
Figure attractors_scene(const SceneArm& arm);
/// Fig. 10: a reach as computed and as the simulated robot makes it.
Figure executed_scene(const SceneArm& arm);
/// Fig. 11: the same reach: joint angles with theta_T, and speeds.
Figure profile_scene(const SceneArm& arm);
/// Fig. 12: horizontal reaches in front of the robot with several gammas.
Figure straight_scene(const SceneArm& arm);
/// Fig. 13: from stretched downwards to stretched sideways.
Figure stretched_scene(const SceneArm& arm);
/// Fig. 14 and Table 1: from behind the neck to the front, with limit avoidance and without.
Figure neck_scene(const SceneArm& arm);
/// Fig. 15: the target is displaced twice during the reach.
Figure displaced_scene(const SceneArm& arm);
/// Fig. 16: the arm is pushed during the reach.
Figure pushed_scene(const SceneArm& arm);

/// The two tasks by which Pattacini, Nori, Natale, Metta & Sandini compare Cartesian controllers ("An experimental
/// evaluation of a novel minimum-jerk cartesian controller for humanoid robots", IROS 2010), scaled to the arm's reach;
/// see docs/results-protocols.md. Each law of `ProtocolLaw` runs them from the middle of the joints' range. They throw
/// std::invalid_argument for an arm that does not reach the task's points.

/// 21 reaches between two points, a new one every 9 s. The curves are those of the last two: the hand's distance to the
/// target, its speed, how far it is along the line between the points and aside of it. Measured are all but the first,
/// and a straight minimum-jerk movement of 1.5 s beside them.
Figure protocol_reaches_scene(const SceneArm& arm);
/// A lemniscate of 1000 points, passed through twice in 300 s, with the target's velocity not told and told: the target
/// and each hand (velocity not told), in the curve's plane, and the distances in both cases.
Figure protocol_lemniscate_scene(const SceneArm& arm);

}  // namespace multireach
