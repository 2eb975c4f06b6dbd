#include <pybind11/stl/filesystem.h>

#include <filesystem>

#include "kinematics/urdf_chain.hpp"
#include "python/arrays.hpp"
#include "runtime/robot_config.hpp"

namespace multireach::python {
namespace {

using Path = std::filesystem::path;

/// Calls `compute(theta, row)` for every row of `theta`; without the interpreter's lock when there are many.
template <class Compute>
void for_rows(const Chain& chain, const Rows& rows, Compute&& compute) {
  const auto all = [&] {
    for (py::ssize_t row = 0; row < rows.count; ++row)
      compute(Eigen::Map<const Eigen::VectorXd>(rows.data + row * chain.size(), chain.size()), row);
  };
  if (rows.count < 64) return all();
  const py::gil_scoped_release release;
  all();
}

template <int N>
using RowMajor = Eigen::Map<Eigen::Matrix<double, N, Eigen::Dynamic, Eigen::RowMajor>>;

py::array_t<double> position(const Chain& chain, const Doubles& theta) {
  const Rows rows(theta, chain.size(), "theta");
  py::array_t<double> result = array_for(rows, {3});
  double* out = result.mutable_data();
  for_rows(chain, rows, [&](const JointVector& each, py::ssize_t row) {
    Eigen::Map<Eigen::Vector3d>(out + row * 3) = chain.position(each);
  });
  return result;
}

/// One matrix of kRows rows for each configuration, as `compute` returns it.
template <int kRows, class Compute>
py::array_t<double> matrices(const Chain& chain, const Doubles& theta, int columns, Compute compute) {
  const Rows rows(theta, chain.size(), "theta");
  py::array_t<double> result = array_for(rows, {kRows, columns});
  double* out = result.mutable_data();
  for_rows(chain, rows, [&](const JointVector& each, py::ssize_t row) {
    RowMajor<kRows>(out + row * kRows * columns, kRows, columns) = compute(each);
  });
  return result;
}

py::array_t<double> pose(const Chain& chain, const Doubles& theta) {
  return matrices<4>(chain, theta, 4, [&](const JointVector& each) { return chain.pose(each).matrix(); });
}

py::array_t<double> jacobian(const Chain& chain, const Doubles& theta) {
  return matrices<3>(chain, theta, chain.size(), [&](const JointVector& each) {
    Eigen::Vector3d p_WT;
    PositionJacobian computed;
    chain.position_and_jacobian(each, p_WT, computed);
    return computed;
  });
}

py::array_t<double> pose_jacobian(const Chain& chain, const Doubles& theta) {
  return matrices<6>(chain, theta, chain.size(), [&](const JointVector& each) {
    Eigen::Isometry3d X_WT;
    PoseJacobian computed;
    chain.pose_and_jacobian(each, X_WT, computed);
    return computed;
  });
}

template <class Get>
py::array_t<double> for_joints(const Chain& chain, Get&& get) {
  JointVector values(chain.size());
  for (int i = 0; i < chain.size(); ++i) values[i] = get(i);
  return array_of(values);
}

}  // namespace

void bind_kinematics(py::module_& module) {
  py::class_<Chain>(module, "Chain", R"(A serial kinematic chain from a base link to a tip link of a URDF.

W is the base link's frame, T the tip link's. `theta` holds n joint positions, rad (m for a prismatic joint): an array of
shape (n,), or (rows, n) for many at once. Other numbers of joints raise ValueError.)")
      .def_static(
          "from_urdf",
          [](const Path& path, const std::string& base, const std::string& tip) {
            return load_chain(path.string(), base, tip);
          },
          py::arg("path"), py::arg("base"), py::arg("tip"),
          "The chain between two links of a URDF file. InputError names the file and what is wrong with it.")
      .def_static("from_urdf_text", &chain_from_urdf, py::arg("urdf"), py::arg("base"), py::arg("tip"),
                  "The chain between two links of a URDF, given as text.")
      .def_static(
          "from_robot", [](const Path& path) { return RobotConfig::load(path.string()).chain; }, py::arg("path"),
          "The chain of a robot.yaml, or of the one in a folder, with its lower speed limits.")
      .def_property_readonly("size", &Chain::size, "The number of moving joints, n.")
      .def_property_readonly("base", &Chain::base)
      .def_property_readonly("tip", &Chain::tip)
      .def_property_readonly("joint_names",
                             [](const Chain& chain) {
                               std::vector<std::string> names;
                               for (const Joint& joint : chain.joints()) names.push_back(joint.name);
                               return names;
                             })
      .def_property_readonly(
          "lower", [](const Chain& chain) { return array_of(chain.lower()); },
          "Lower position limits, rad or m; -inf for continuous joints.")
      .def_property_readonly(
          "upper", [](const Chain& chain) { return array_of(chain.upper()); },
          "Upper position limits, rad or m; inf for continuous joints.")
      .def_property_readonly(
          "velocity", [](const Chain& chain) { return array_of(chain.velocity()); },
          "Speed limits, rad/s or m/s; inf where there are none.")
      .def_property_readonly(
          "effort", [](const Chain& chain) { return for_joints(chain, [&](int i) { return chain.joint(i).effort; }); },
          "Effort limits, N m or N; inf where there are none.")
      .def_property_readonly(
          "sample_lower",
          [](const Chain& chain) { return for_joints(chain, [&](int i) { return chain.sample_lower(i); }); },
          "With sample_upper: the range to draw joint configurations from; finite, also for continuous joints.")
      .def_property_readonly(
          "sample_upper",
          [](const Chain& chain) { return for_joints(chain, [&](int i) { return chain.sample_upper(i); }); })
      .def_property_readonly("reach", &Chain::reach, "Upper bound of the distance from the first joint to the tip, m.")
      .def("position", &position, py::arg("theta"), "p_WT, the tip's position in W, m: shape (3,) or (rows, 3).")
      .def("pose", &pose, py::arg("theta"), "X_WT as homogeneous matrices: shape (4, 4) or (rows, 4, 4).")
      .def("jacobian", &jacobian, py::arg("theta"), "d p_WT / d theta in W: shape (3, n) or (rows, 3, n).")
      .def("pose_jacobian", &pose_jacobian, py::arg("theta"),
           "The geometric Jacobian in W, linear velocity (rows 0-2) above angular: shape (6, n) or (rows, 6, n).")
      .def(
          "clamped",
          [](const Chain& chain, const Doubles& theta) {
            return array_of(chain.clamped(joints_of(chain, theta, "theta")));
          },
          py::arg("theta"), "The joint configuration with every joint clamped to its limits.")
      .def(
          "limit_excess",
          [](const Chain& chain, const Doubles& theta) { return chain.limit_excess(joints_of(chain, theta, "theta")); },
          py::arg("theta"), "Largest violation of a position limit, rad or m; 0 inside the limits.")
      .def("__repr__", [](const Chain& chain) {
        return "<multireach.Chain " + chain.base() + " to " + chain.tip() + ", " + std::to_string(chain.size()) +
               " joints>";
      });
}

}  // namespace multireach::python
