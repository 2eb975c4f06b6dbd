#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "kinematics/chain.hpp"

namespace multireach {

/// The base or the tip is no link of the URDF.
class UnknownLinkError : public std::invalid_argument {
 public:
  UnknownLinkError(std::string asked_as, const std::string& link, std::string known)
      : std::invalid_argument("has no link '" + link + "', asked for as " + asked_as + "; it has " + known),
        which(std::move(asked_as)),
        links(std::move(known)) {}
  std::string which;  ///< "base" or "tip"
  std::string links;  ///< of the URDF, with commas between them
};

/// The chain between two links of a URDF, given as text. The base may be above the tip, below it, or on another branch.
/// Supports revolute, continuous, prismatic and fixed joints. A continuous joint without a velocity limit, and any
/// without a positive effort limit, has none. The soft limits of a `safety_controller`, where written, narrow the
/// position limits. Throws std::invalid_argument with one sentence (the caller adds the file
/// name) when the text is not a URDF, its links are no tree, a link is missing (UnknownLinkError), the chain has no
/// moving joint, a joint of the chain is mimic, floating or planar, or its limits or axis are invalid: a velocity limit
/// must be positive, the upper position limit above the lower. Texts of more than 16 MB, 64 nested elements or 2000
/// links are refused before they can exhaust memory or the stack.
Chain chain_from_urdf(std::string_view urdf_xml, const std::string& base, const std::string& tip);

}  // namespace multireach
