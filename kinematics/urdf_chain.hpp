#pragma once

#include <string>
#include <string_view>

#include "kinematics/chain.hpp"

namespace multireach {

/// The chain between two links of a URDF, given as text. The base may be above the tip, below it, or on another branch.
/// Revolute, continuous, prismatic and fixed joints are taken; a velocity or effort limit that is absent, zero or
/// negative means no limit. Throws std::invalid_argument with one sentence (without a file name: the caller knows it)
/// when the text is no URDF, a link is missing, the chain has no moving joint, a joint of the chain is mimic, floating
/// or planar, or its limits or axis make no sense.
Chain chain_from_urdf(std::string_view urdf_xml, const std::string& base, const std::string& tip);

}  // namespace multireach
