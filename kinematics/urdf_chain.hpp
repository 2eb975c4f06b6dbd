#pragma once

#include <string>
#include <string_view>

#include "kinematics/chain.hpp"

namespace multireach {

/// The chain between two links of a URDF, given as text. The base may be above the tip, below it, or on another branch.
/// Supports revolute, continuous, prismatic and fixed joints. A continuous joint without a velocity limit, and any
/// without a positive effort limit, has none. The soft limits of a `safety_controller`, where written, narrow the
/// position limits. Throws std::invalid_argument with one sentence (the caller adds the file
/// name) when the text is not a URDF, its links are no tree, a link is missing, the chain has no moving joint, a joint
/// of the chain is mimic, floating or planar, or its limits or axis are invalid: a velocity limit must be positive.
/// Texts of more than 16 MB, 64 nested elements or 2000 links are refused before they can exhaust memory or the stack.
Chain chain_from_urdf(std::string_view urdf_xml, const std::string& base, const std::string& tip);

}  // namespace multireach
