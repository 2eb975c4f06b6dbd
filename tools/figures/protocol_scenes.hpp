#pragma once

#include "kinematics/chain.hpp"
#include "tools/figures/table.hpp"

namespace multireach {

/// The two tasks by which Pattacini, Nori, Natale, Metta & Sandini compare Cartesian controllers ("An experimental
/// evaluation of a novel minimum-jerk cartesian controller for humanoid robots", IROS 2010), scaled to the arm's reach.
/// Each law of `ProtocolLaw` runs them from the middle of the joints' range; its columns have its number, and `law` is
/// that number. All throw std::invalid_argument for an arm that does not reach the task's points.

/// 21 reaches between two points, a new one every 9 s: the hand's distance to the target, its speed, how far it is
/// along the line between the points and aside of it, 20 times a second, for the last two reaches.
Table protocol_reaches_scene(const Chain& chain);
/// Their measures, one row for each law, and a last one (law -1) for a straight minimum-jerk movement of 1.5 s.
Table protocol_reaches_measures_scene(const Chain& chain);
/// A lemniscate of 1000 points, passed through twice in 300 s: the target and each hand, in the curve's plane, the
/// target's velocity not told; and the distances, with and without it.
Table protocol_lemniscate_scene(const Chain& chain);
/// Its measures, one row for each law without (told = 0) and with (1) the target's velocity.
Table protocol_lemniscate_measures_scene(const Chain& chain);

}  // namespace multireach
