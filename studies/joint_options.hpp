#pragma once

#include <string>

#include "kinematics/chain.hpp"
#include "runtime/files.hpp"
#include "runtime/program.hpp"

namespace multireach {

inline constexpr const char* kAccelerationHelp =
    "A1,A2,...: law guarded: acceleration limit of each joint, or one for all, rad/s^2 (m/s^2); inf: none; default: "
    "the speed limit in 0.1 s";

/// The values of an option with one positive number for all joints, or one for each; empty, for the defaults of the
/// law, where it is not given.
inline JointVector joint_values_from(const std::string& option, const std::string& text, const Chain& chain) {
  if (text.empty()) return {};
  const std::vector<double> values = parse_numbers(option, text);
  for (const double value : values) {
    if (!(value > 0)) throw InputError(option + " '" + text + "' has a value that is not positive");
  }
  if (values.size() == 1) return JointVector::Constant(chain.size(), values.front());
  if (values.size() != static_cast<size_t>(chain.size())) {
    throw InputError(option + " has " + std::to_string(values.size()) +
                     " values; expected one, or one for each of the " + std::to_string(chain.size()) + " joints");
  }
  return Eigen::Map<const Eigen::VectorXd>(values.data(), chain.size());
}

}  // namespace multireach
