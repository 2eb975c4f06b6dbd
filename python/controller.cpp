#include <sstream>

#include "controller/ik/multi_start.hpp"
#include "controller/task/target_check.hpp"
#include "python/law_parameters.hpp"

namespace multireach::python {
namespace {

using namespace controller;

JointVector one_or_each(const Chain& chain, const py::handle& value, const std::string& name) {
  if (py::isinstance<py::float_>(value) || py::isinstance<py::int_>(value))
    return JointVector::Constant(chain.size(), value.cast<double>());
  return joints_of(chain, value.cast<Doubles>(), name);
}

TaskTarget make_target(const Doubles& position, const Doubles& velocity, const std::optional<Doubles>& direction,
                       const std::optional<Doubles>& orientation) {
  TaskTarget target;
  target.position = vector3_of(position, "position");
  target.velocity = vector3_of(velocity, "velocity");
  if (direction && orientation) throw std::invalid_argument("TaskTarget: give a direction or an orientation, not both");
  if (direction) {
    target.task = TaskKind::kPointing;
    target.direction = vector3_of(*direction, "direction");
  }
  if (orientation) {
    if (orientation->ndim() != 2 || orientation->shape(0) != 3 || orientation->shape(1) != 3)
      throw std::invalid_argument("orientation: expected a rotation matrix of shape (3, 3)");
    target.task = TaskKind::kPose;
    target.orientation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(orientation->data());
  }
  return target;
}

py::object nearest(const MultiStartIk& ik, const Chain& chain, const Doubles& positions, const Doubles& theta) {
  const Rows targets(positions, 3, "position"), from(theta, chain.size(), "theta");
  if (from.count != targets.count && from.count != 1)
    throw std::invalid_argument("nearest: expected as many rows of theta as positions, or one");
  py::array_t<double> result = array_for(targets, {chain.size()});
  double* out = result.mutable_data();
  py::ssize_t found = 0;
  {
    const py::gil_scoped_release release;
    for (py::ssize_t row = 0; row < targets.count; ++row) {
      const Eigen::Vector3d x_T = Eigen::Map<const Eigen::Vector3d>(targets.data + 3 * row);
      const JointVector start =
          Eigen::Map<const Eigen::VectorXd>(from.data + (from.count == 1 ? 0 : row) * chain.size(), chain.size());
      const auto solution = x_T.allFinite() && start.allFinite() ? ik.nearest(x_T, start) : std::nullopt;
      Eigen::Map<Eigen::VectorXd>(out + row * chain.size(), chain.size()) =
          solution.value_or(JointVector::Constant(chain.size(), std::numeric_limits<double>::quiet_NaN()));
      found += solution.has_value();
    }
  }
  if (targets.one && found == 0) return py::none();
  return result;
}

/// A law whose steps Python drives.
struct Ik {
  Chain chain;
  Tool tool;
  MultiStartIk search;
};

py::tuple solution_of(const IkSolution& solution) {
  return py::make_tuple(array_of(solution.theta), solution.error_m);
}

/// Throws for a target that every law refuses.
TargetResult accepted(TargetResult result, const TaskTarget& target) {
  if (result == TargetResult::kRefused) {
    const char* fault = target_fault(target);
    throw std::invalid_argument(fault ? fault : "the target is not valid");
  }
  if (result == TargetResult::kNotStarted)
    throw std::runtime_error("call start() first: the law has no joint positions");
  return result;
}

Obstacle make_obstacle(const std::string& shape, const Doubles& position, const Doubles& size,
                       const std::optional<Doubles>& orientation) {
  static const std::map<std::string, std::pair<Obstacle::Shape, int>> kShapes{
      {"sphere", {Obstacle::Shape::kSphere, 1}},
      {"capsule", {Obstacle::Shape::kCapsule, 2}},
      {"box", {Obstacle::Shape::kBox, 3}}};
  const auto at = kShapes.find(shape);
  if (at == kShapes.end()) throw std::invalid_argument("shape: '" + shape + "' is not one of sphere, capsule, box");
  Obstacle obstacle;
  obstacle.shape = at->second.first;
  if (size.size() != at->second.second)
    throw std::invalid_argument("size: a " + shape + " has " + std::to_string(at->second.second) + " numbers");
  for (py::ssize_t i = 0; i < size.size(); ++i) obstacle.size[i] = size.data()[i];
  obstacle.X_WO.translation() = vector3_of(position, "position");
  if (orientation) {
    if (orientation->ndim() != 2 || orientation->shape(0) != 3 || orientation->shape(1) != 3)
      throw std::invalid_argument("orientation: expected a rotation matrix of shape (3, 3)");
    obstacle.X_WO.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(orientation->data());
  }
  if (!is_valid(obstacle))
    throw std::invalid_argument(
        "Obstacle: a number is not finite, a size not positive, or the orientation no rotation");
  return obstacle;
}

}  // namespace

GuardedParameters guarded_parameters(const Chain& chain, const py::kwargs& arguments) {
  GuardedParameters p;
  AttractorMotion motion = attractor_motion(p.gains, kReferenceRate);
  bool per_step = false, in_time = false;
  for (const auto& [key, value] : arguments) {
    const auto name = key.cast<std::string>();
    if (value.is_none()) continue;
    per_step = per_step || name == "alpha" || name == "beta";
    in_time = in_time || name == "natural_frequency" || name == "damping_ratio";
    if (name == "gamma")
      p.gamma = value.cast<double>();
    else if (name == "alpha")
      p.gains.alpha = value.cast<double>();
    else if (name == "beta")
      p.gains.beta = value.cast<double>();
    else if (name == "natural_frequency")
      motion.natural_frequency = value.cast<double>();
    else if (name == "damping_ratio")
      motion.damping_ratio = value.cast<double>();
    else if (name == "steps_per_second")
      p.steps_per_second = value.cast<double>();
    else if (name == "acceleration")
      p.acceleration = one_or_each(chain, value, name);
    else if (name == "joint_weights")
      p.joint_weights = one_or_each(chain, value, name);
    else if (name == "extrapolation_s")
      p.extrapolation_s = value.cast<double>();
    else if (name == "tool_axis")
      p.tool.axis = vector3_of(value.cast<Doubles>(), name);
    else if (name == "orientation_length_m")
      p.tool.orientation_length_m = value.cast<double>();
    else if (name == "link_radius_m")
      p.body.link_radius_m = value.cast<double>();
    else if (name == "margin_m")
      p.body.margin_m = value.cast<double>();
    else if (name == "self_collision")
      p.body.self_collision = value.cast<bool>();
    else if (name == "path_work")
      p.path_work = value.cast<int>();
    else if (name == "seed")
      p.ik.seed = value.cast<uint64_t>();
    else
      throw std::invalid_argument("the law has no parameter '" + name + "'; expected one of " + kParameterNames);
  }
  if (per_step && in_time)
    throw std::invalid_argument("alpha and beta: expected without natural_frequency and damping_ratio");
  if (in_time) p.attractor = motion;
  return p;
}

TaskTarget task_target_of(const py::object& target) {
  if (py::isinstance<TaskTarget>(target)) return target.cast<TaskTarget>();
  TaskTarget position;
  position.position = vector3_of(target.cast<Doubles>(), "target");
  return position;
}

void bind_controller(py::module_& module) {
  py::enum_<TargetResult>(module, "TargetResult", "Whether a target is reachable.")
      .value("REACHABLE", TargetResult::kReachable, "An IK solution inside the limits exists.")
      .value("UNREACHABLE", TargetResult::kUnreachable, "None was found: the arm goes as near as it can.");
  py::enum_<Obstruction>(module, "Obstruction", "What keeps the hand from its target.")
      .value("NONE", Obstruction::kNone)
      .value("TARGET", Obstruction::kTarget, "The target is inside an obstacle, or too near to it.")
      .value("OBSTACLE", Obstruction::kObstacle, "An obstacle, or the arm's own links, in the way.");
  py::class_<TaskTarget>(module, "TaskTarget", R"(A target of the end effector.

position: m, in W, shape (3,). velocity: m per integration step, in W. direction: unit vector in W that the tool's axis
takes up. orientation: R_WT, shape (3, 3); give at most one of the two. Where a target is expected, a position alone will do.)")
      .def(py::init(&make_target), py::arg("position"), py::arg("velocity") = std::vector<double>(3, 0.0),
           py::arg("direction") = py::none(), py::arg("orientation") = py::none())
      .def_property_readonly("position", [](const TaskTarget& target) { return array_of(target.position); });
  py::class_<Obstacle>(module, "Obstacle", R"(An obstacle, in W.

shape: "sphere" (size: radius), "capsule" (radius, length of its axis along z) or "box" (lengths along x, y, z); m.
position: of its centre, m. orientation: its rotation matrix, shape (3, 3).)")
      .def(py::init(&make_obstacle), py::arg("shape"), py::arg("position"), py::arg("size"),
           py::arg("orientation") = py::none());

  py::class_<Ik>(module, "MultiStartIk", R"(Inverse kinematics inside the joint limits.

Position targets of a shoulder-elbow arm have a closed form; all others use damped Newton steps from seeded random starts.)")
      .def(py::init([](const Chain& chain, const Doubles& tool_axis, double orientation_length_m,
                       const py::object& joint_weights, uint64_t seed) {
             IkOptions options;
             options.seed = seed;
             if (!joint_weights.is_none()) options.joint_weights = one_or_each(chain, joint_weights, "joint_weights");
             const Tool tool{vector3_of(tool_axis, "tool_axis"), orientation_length_m};
             return Ik{chain, tool, MultiStartIk(chain, options, tool)};
           }),
           py::arg("chain"), py::kw_only(), py::arg("tool_axis") = std::vector<double>{0, 0, 1},
           py::arg("orientation_length_m") = 0.1, py::arg("joint_weights") = py::none(), py::arg("seed") = 1)
      .def(
          "nearest",
          [](const Ik& ik, const Doubles& position, const Doubles& theta) {
            return nearest(ik.search, ik.chain, position, theta);
          },
          py::arg("position"), py::arg("theta"),
          R"(The solution for a position (m, in W) nearest to theta; None when there is none.

For positions of shape (rows, 3): an array of shape (rows, n), with NaN in the rows without a solution; theta has as many
rows, or one.)")
      .def(
          "best",
          [](const Ik& ik, const py::object& target, const Doubles& theta) {
            const TaskTarget task = task_target_of(target);
            if (const char* fault = target_fault(task)) throw std::invalid_argument(fault);
            return solution_of(ik.search.best(task, joints_of(ik.chain, theta, "theta")));
          },
          py::arg("target"), py::arg("theta"),
          "(theta, error_m): the solution nearest to theta, or where there is none the configuration with the smallest "
          "task error.")
      .def(
          "first",
          [](const Ik& ik, const py::object& target, const Doubles& theta) {
            const TaskTarget task = task_target_of(target);
            if (const char* fault = target_fault(task)) throw std::invalid_argument(fault);
            return solution_of(ik.search.first(task, joints_of(ik.chain, theta, "theta")));
          },
          py::arg("target"), py::arg("theta"), "Like best, but the first solution found, in a fraction of the time.")
      .def_property_readonly("closed_form", [](const Ik& ik) { return ik.search.closed_form(); });

  using Law = GuardedLaw;
  py::class_<Law>(
      module, "GuardedLaw",
      R"(The guarded law for one arm: takes a target and computes joint positions, one integration step at a time.

Parameters, by keyword: gamma (rad^2/m^2), alpha and beta (per step of 1/140 s) or, instead, natural_frequency (rad/s)
and damping_ratio (at least 1), steps_per_second (140; the motion is the same at any), acceleration and joint_weights (one number or one for each joint), extrapolation_s, tool_axis, orientation_length_m, link_radius_m (with it,
obstacles and self-collision are avoided), margin_m, self_collision, path_work (70: nearly straight ways of the hand, but slower; not in batches), seed.
docs/guarantees.md states what the law keeps.)")
      .def(py::init([](const Chain& chain, const py::kwargs& parameters) {
             return Law(chain, guarded_parameters(chain, parameters));
           }),
           py::arg("chain"))
      .def("__copy__", [](const Law& law) { return Law(law); })
      .def("__deepcopy__", [](const Law& law, const py::dict&) { return Law(law); })
      .def_property_readonly("chain", &Law::chain, py::return_value_policy::reference_internal)
      .def(
          "start",
          [](Law& law, const Doubles& theta) {
            if (!law.start(joints_of(law.chain(), theta, "theta")))
              throw std::invalid_argument("theta: expected finite numbers within 1e5 rad");
          },
          py::arg("theta"),
          "Puts the arm at rest at theta, rad or m; outside the limits is allowed: the arm then returns.")
      .def(
          "set_target",
          [](Law& law, const py::object& target, const std::optional<Doubles>& theta_target) {
            const TaskTarget task = task_target_of(target);
            return accepted(theta_target ? law.set_target(task, joints_of(law.chain(), *theta_target, "theta_target"))
                                         : law.set_target(task),
                            task);
          },
          py::arg("target"), py::arg("theta_target") = py::none(),
          "Sets a new target and searches the IK solution nearest to the arm, unless theta_target gives one.")
      .def(
          "update_target",
          [](Law& law, const py::object& target) {
            const TaskTarget task = task_target_of(target);
            return accepted(law.update_target(task), task);
          },
          py::arg("target"), "Updates a target that has moved a little, without a search.")
      .def(
          "set_joint_target",
          [](Law& law, const Doubles& theta) { return law.set_joint_target(joints_of(law.chain(), theta, "theta")); },
          py::arg("theta"), "Goes to a joint configuration. False when it is outside the limits, and before start().")
      .def(
          "set_obstacles",
          [](Law& law, const std::vector<Obstacle>& obstacles) { return law.set_obstacles(obstacles); },
          py::arg("obstacles"), "Replaces all obstacles. Returns how many were refused: all, without link_radius_m.")
      .def(
          "step",
          [](Law& law, int count) {
            for (int i = 0; i < count; ++i) law.step();
          },
          py::arg("count") = 1, "Integration steps.")
      .def(
          "run", [](Law& law, int steps, int every) { return trajectory_of(law, steps, every); }, py::arg("steps"),
          py::arg("every") = 1,
          "Integration steps; the joint positions after each `every`-th: shape (steps // every, n).")
      .def(
          "compensate",
          [](Law& law, const Doubles& displacement) {
            law.compensate(joints_of(law.chain(), displacement, "displacement"));
          },
          py::arg("displacement"), "Sets the measured displacement of the arm from theta, rad or m.")
      .def("clearance", &Law::clearance, "Smallest distance to an obstacle or between links, minus the margin, m.")
      .def_property_readonly(
          "theta", [](const Law& law) { return array_of(law.theta()); }, "Joint positions, shape (n,).")
      .def_property_readonly(
          "velocity", [](const Law& law) { return array_of(law.velocity()); },
          "Per step; times steps_per_second: rad/s or m/s.")
      .def_property_readonly("theta_target", [](const Law& law) { return array_of(law.theta_target()); })
      .def_property_readonly(
          "x", [](const Law& law) { return array_of(law.x()); }, "The hand's position in W, m.")
      .def_property_readonly(
          "x_target", [](const Law& law) { return array_of(law.x_target()); }, "Where the hand goes, m, in W.")
      .def_property_readonly("gamma", &Law::gamma)
      .def_property_readonly("residual_m", &Law::residual_m)
      .def_property_readonly("unreachable", &Law::unreachable)
      .def_property_readonly("obstruction", &Law::obstruction)
      .def_property_readonly("ik_searches", &Law::ik_searches);
}

}  // namespace multireach::python
