#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "kinematics/chain.hpp"

namespace multireach {

/// The joint names of a chain, as used in messages.
inline std::vector<std::string> joint_names(const Chain& chain) {
  std::vector<std::string> names;
  for (const Joint& joint : chain.joints()) names.push_back(joint.name);
  return names;
}

inline std::vector<double> to_field(const JointVector& vector) {
  return {vector.begin(), vector.end()};
}

/// The chain's joint values from a message, which may list joints in any order and have additional ones; nothing when a
/// joint is missing.
[[nodiscard]] inline std::optional<JointVector> from_fields(const Chain& chain, const std::vector<std::string>& names,
                                                            const std::vector<double>& values) {
  if (names.size() != values.size()) return std::nullopt;
  JointVector vector(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    const auto found = std::ranges::find(names, chain.joint(i).name);
    if (found == names.end()) return std::nullopt;
    vector[i] = values[static_cast<size_t>(found - names.begin())];
  }
  return vector;
}

}  // namespace multireach
