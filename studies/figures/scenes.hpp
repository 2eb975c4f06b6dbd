#pragma once

#include "kinematics/chain.hpp"
#include "studies/figures/figure.hpp"

namespace multireach {

/// The scenes of docs/guarantees.md, one for each guarantee. Times are nominal, s; all other units are SI.

/// A reach in which the law `paper` passes a joint limit: that joint under both laws.
Table limits_scene(const Chain& chain);
/// A reach that ends at a spurious attractor under the law `paper`: hand-to-target distance under both laws, and gamma.
Table arrival_scene(const Chain& chain);
/// A reach from arm stretched down to arm stretched sideways (Hoap2).
Table singularity_scene(const Chain& chain);
/// A target that rests, moves, jumps, is noisy, is lost, returns, and becomes unreachable (Hoap2).
Table targets_scene(const Chain& chain);
/// A target that moves until another IK solution is clearly nearer (Hoap2).
Table posture_choice_scene(const Chain& chain);
/// Someone holds the arm away from its command for a second (Hoap2).
Table push_scene(const Chain& chain);
/// A reach around a wall (Hoap2).
Table obstacle_scene(const Chain& chain);
/// Reaches among 12 random obstacles, between collision-free configurations: one row for each.
Table clutter_scene(const Chain& chain);
/// A target with an orientation, and one with a pointing direction; for arms of 6 joints or more.
Table orientation_scene(const Chain& chain);

/// The figures of Hersch & Billard (2008), in their order; see docs/results.md. All except the first use the Hoap2.

/// Fig. 1: one attractor with several gains.
Figure vite_scene(const SceneArm& arm);
/// Fig. 4: the weight (28) of the last joint over its range and beyond.
Figure weight_scene(const SceneArm& arm);
/// Fig. 7: the ratio of failed random reaches against gamma.
Figure failures_scene(const SceneArm& arm);
/// Fig. 8: the targets that `paper` does not reach.
Figure unreached_scene(const SceneArm& arm);
/// Benefits and costs of gamma under both laws; not in the paper.
Figure gamma_scene(const SceneArm& arm);
/// Fig. 9: final joint angles of random reaches against theta_T; all points off the diagonal, and some on it.
Figure attractors_scene(const SceneArm& arm);
/// Fig. 10: a reach as computed and as executed by the simulated robot.
Figure executed_scene(const SceneArm& arm);
/// Fig. 11: the reach of Fig. 10: joint angles with theta_T, and speeds.
Figure profile_scene(const SceneArm& arm);
/// Fig. 12: horizontal reaches in front of the robot with several gammas.
Figure straight_scene(const SceneArm& arm);
/// Fig. 13: a reach from arm stretched down to arm stretched sideways.
Figure stretched_scene(const SceneArm& arm);
/// Fig. 14 and Table 1: a reach from behind the neck to the front, with and without limit avoidance.
Figure neck_scene(const SceneArm& arm);
/// Fig. 15: the target is displaced twice during the reach.
Figure displaced_scene(const SceneArm& arm);
/// Fig. 16: the arm is pushed during the reach.
Figure pushed_scene(const SceneArm& arm);

/// The two tasks with which Pattacini, Nori, Natale, Metta & Sandini compare Cartesian controllers ("An experimental
/// evaluation of a novel minimum-jerk cartesian controller for humanoid robots", IROS 2010), scaled to the arm's reach;
/// see docs/results-protocols.md. Each law of `ProtocolLaw` runs them from the middle of the joints' ranges. The scenes
/// throw std::invalid_argument for an arm that does not reach the task's points.

/// 21 reaches between two points, a new one every 9 s. The curves show the last two: the hand's distance to the target,
/// its speed, and its position along the line between the points and beside it. The measures cover all reaches but the
/// first, and for comparison a straight minimum-jerk movement of 1.5 s.
Figure protocol_reaches_scene(const SceneArm& arm);
/// A lemniscate of 1000 points, traversed twice in 300 s, once without and once with the target's velocity. The curves
/// show the target and each hand (without the velocity) in the plane of the curve, and the distances in both cases.
Figure protocol_lemniscate_scene(const SceneArm& arm);

}  // namespace multireach
