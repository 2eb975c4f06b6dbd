#include "controller/batch/guarded_batch.hpp"
#include "python/law_parameters.hpp"

namespace multireach::python {
namespace {

using namespace controller;

/// Many arms, of which the first `arms` are the user's: the library rounds up to whole blocks of lanes.
struct Batch {
  int arms;
  MultiStartIk search;
  GuardedBatch law;

  const Chain& chain() const { return law.chain(); }

  py::array_t<bool> start(const Doubles& thetas, const Doubles& targets, const std::optional<Doubles>& theta_targets,
                          const std::optional<double>& gamma) {
    const int n = chain().size();
    const Rows theta(thetas, n, "theta"), target(targets, 3, "target");
    const Rows goal(theta_targets.value_or(thetas), n, "theta_target");
    for (const Rows* rows : {&theta, &target, &goal}) {
      if (rows->count != arms && rows->count != 1)
        throw std::invalid_argument("start: expected " + std::to_string(arms) + " rows, one for each arm, or one row");
    }
    py::array_t<bool> started(arms);
    bool* out = started.mutable_data();
    const auto row = [](const Rows& rows, int arm, int columns) {
      return Eigen::Map<const Eigen::VectorXd>(rows.data + (rows.count == 1 ? 0 : arm) * columns, columns);
    };
    const py::gil_scoped_release release;
    for (int arm = 0; arm < arms; ++arm) {
      const JointVector from = row(theta, arm, n);
      const Eigen::Vector3d x_T = row(target, arm, 3);
      std::optional<JointVector> to;
      if (theta_targets)
        to = JointVector(row(goal, arm, n));
      else if (from.allFinite() && x_T.allFinite())
        to = search.nearest(x_T, from);
      out[arm] = to && law.start(arm, from, x_T, *to, gamma);
      if (!out[arm]) law.stop(arm);
    }
    return started;
  }

  template <class Get>
  py::array_t<double> read(int columns, Get&& get) const {
    py::array_t<double> result({arms, columns});
    double* out = result.mutable_data();
    for (int arm = 0; arm < arms; ++arm) {
      Eigen::Map<Eigen::VectorXd> row(out + arm * columns, columns);
      const uint32_t mask = law.running()[static_cast<size_t>(arm / kRowLanes)];
      if (mask >> arm % kRowLanes & 1U)
        row = get(arm);
      else
        row.setConstant(std::numeric_limits<double>::quiet_NaN());
    }
    return result;
  }
};

}  // namespace

void bind_batch(py::module_& module) {
  py::class_<Batch>(
      module, "GuardedBatch",
      R"(Many arms of one kind under the guarded law, computed side by side; each goes to a fixed position.

The motion of each arm is bit-identical to GuardedLaw's. Parameters as GuardedLaw, without a body.)")
      .def(py::init([](const Chain& chain, int arms, const py::kwargs& arguments) {
             const GuardedParameters parameters = guarded_parameters(chain, arguments);
             return Batch{arms, MultiStartIk(chain, guarded_ik_options(chain, parameters), parameters.tool),
                          GuardedBatch(chain, parameters, arms)};
           }),
           py::arg("chain"), py::arg("arms"))
      .def_property_readonly("size", [](const Batch& batch) { return batch.arms; })
      .def("start", &Batch::start, py::arg("theta"), py::arg("target"), py::arg("theta_target") = py::none(),
           py::arg("gamma") = py::none(),
           R"(Puts every arm at rest at its row of theta, with a target position (m, in W).

theta: shape (arms, n) or (n,); target: (arms, 3) or (3,); theta_target: IK solutions, else they are searched. Returns an
array of bool: which arms run. The others have no solution, or numbers that are not valid; theta and x are NaN for them.)")
      .def(
          "step",
          [](Batch& batch, int count) {
            const py::gil_scoped_release release;
            for (int i = 0; i < count; ++i) batch.law.step();
          },
          py::arg("count") = 1, "Integration steps of every arm that runs.")
      .def_property_readonly(
          "theta",
          [](const Batch& batch) {
            return batch.read(batch.chain().size(), [&](int arm) { return batch.law.theta(arm); });
          },
          "Joint positions, shape (arms, n).")
      .def_property_readonly(
          "x", [](const Batch& batch) { return batch.read(3, [&](int arm) { return batch.law.x(arm); }); },
          "The hands' positions in W, m, shape (arms, 3).");
}

}  // namespace multireach::python
