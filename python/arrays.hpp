#pragma once

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>

#include "kinematics/chain.hpp"

namespace multireach::python {

namespace py = pybind11;

/// Numbers of any array; those of a contiguous array of float64 are read where they are.
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Rows of `columns` numbers: an array of shape (rows, columns), or (columns,), which is one row.
struct Rows {
  const double* data;
  py::ssize_t count;
  bool one;  ///< the array had no dimension for the rows: neither has the result

  /// Throws std::invalid_argument that calls the array `name`.
  Rows(const Doubles& array, py::ssize_t columns, const std::string& name) : data(array.data()) {
    one = array.ndim() == 1;
    count = one ? 1 : array.shape(0);
    if (array.ndim() < 1 || array.ndim() > 2 || array.shape(array.ndim() - 1) != columns)
      throw std::invalid_argument(name + ": expected an array of shape (" + std::to_string(columns) + ",) or (rows, " +
                                  std::to_string(columns) + ")");
  }
};

/// A new array of shape (count, shape...), or (shape...) for one row.
inline py::array_t<double> array_for(const Rows& rows, std::vector<py::ssize_t> shape) {
  if (!rows.one) shape.insert(shape.begin(), rows.count);
  return py::array_t<double>(shape);
}

/// A new array of shape (n,).
inline py::array_t<double> array_of(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return py::array_t<double>(values.size(), values.data());
}
/// A new array of shape (rows, columns).
inline py::array_t<double> matrix_of(const Eigen::Ref<const Eigen::MatrixXd>& values) {
  py::array_t<double> array({values.rows(), values.cols()});
  Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(array.mutable_data(), values.rows(), values.cols()) =
      values;
  return array;
}

/// n numbers as a joint vector. Throws std::invalid_argument that calls the array `name`.
inline JointVector joints_of(const Chain& chain, const Doubles& array, const std::string& name) {
  if (array.ndim() != 1 || array.shape(0) != chain.size())
    throw std::invalid_argument(name + ": expected an array of " + std::to_string(chain.size()) +
                                " numbers, one for each joint");
  return Eigen::Map<const Eigen::VectorXd>(array.data(), chain.size());
}
inline Eigen::Vector3d vector3_of(const Doubles& array, const std::string& name) {
  if (array.ndim() != 1 || array.shape(0) != 3) throw std::invalid_argument(name + ": expected an array of 3 numbers");
  return Eigen::Map<const Eigen::Vector3d>(array.data());
}

/// The joint positions of a law after each `every`-th of its next steps, shape (steps / every, n).
template <class Law>
py::array_t<double> trajectory_of(Law& law, int steps, int every) {
  if (steps < 0 || every < 1) throw std::invalid_argument("run: expected steps >= 0 and every >= 1");
  const int n = law.chain().size();
  py::array_t<double> trajectory({steps / every, n});
  double* out = trajectory.mutable_data();
  const py::gil_scoped_release release;
  for (int step = 1; step <= steps; ++step) {
    law.step();
    if (step % every == 0) {
      Eigen::Map<Eigen::VectorXd>(out, n) = law.theta();
      out += n;
    }
  }
  return trajectory;
}

// Each adds its part to the module.
void bind_kinematics(py::module_& module);
void bind_controller(py::module_& module);
void bind_paper_law(py::module_& module);
void bind_batch(py::module_& module);
void bind_vision(py::module_& module);
void bind_messages(py::module_& module);
void bind_logs(py::module_& module);
void bind_bus(py::module_& module);
void bind_replay(py::module_& module);

}  // namespace multireach::python
