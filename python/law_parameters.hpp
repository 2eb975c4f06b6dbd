#pragma once

#include "controller/law/guarded_law.hpp"
#include "python/arrays.hpp"

namespace multireach::python {

/// Parameters of the guarded law from keyword arguments, as `kParameterNames` lists. Throws std::invalid_argument for
/// another name.
controller::GuardedParameters guarded_parameters(const Chain& chain, const py::kwargs& arguments);

inline constexpr const char* kParameterNames =
    "gamma, alpha, beta, natural_frequency, damping_ratio, steps_per_second, acceleration, joint_weights, "
    "extrapolation_s, tool_axis, "
    "orientation_length_m, link_radius_m, margin_m, self_collision, path_work, seed";

/// A target from a TaskTarget or from a position, 3 numbers.
controller::TaskTarget task_target_of(const py::object& target);

}  // namespace multireach::python
