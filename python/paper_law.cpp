#include "controller/law/paper_law.hpp"

#include "controller/ik/multi_start.hpp"
#include "python/arrays.hpp"

namespace multireach::python {
namespace {

using namespace controller;

/// The law `paper` for one arm, with its target.
class PaperLaw {
 public:
  PaperLaw(const Chain& chain, double gamma, double alpha, double beta, bool limit_avoidance)
      : chain_(chain), parameters_{{alpha, beta}, gamma, limit_avoidance}, search_(chain) {
    if (!(gamma >= 0) || !(alpha >= 0) || !(beta >= 0) || !std::isfinite(gamma + alpha + beta))
      throw std::invalid_argument("PaperLaw: expected gamma, alpha and beta finite and not negative");
    start(JointVector::Zero(chain.size()));
  }

  void start(const JointVector& theta) {
    if (!theta.allFinite()) throw std::invalid_argument("theta: expected finite numbers");
    state_ = paper_state_at_rest(chain_, theta, theta);
    x_T_ = state_.x;
    x_T_velocity_.setZero();
  }
  /// Returns whether theta_T is known; without `theta_target` it is the IK solution nearest to the arm.
  bool set_target(const Eigen::Vector3d& x_T, const Eigen::Vector3d& velocity,
                  std::optional<JointVector> theta_target) {
    if (!x_T.allFinite() || !velocity.allFinite()) throw std::invalid_argument("target: expected finite numbers");
    if (!theta_target) theta_target = search_.nearest(x_T, state_.theta);
    if (theta_target && !theta_target->allFinite())
      throw std::invalid_argument("theta_target: expected finite numbers");
    x_T_ = x_T;
    x_T_velocity_ = velocity;
    if (theta_target) state_.theta_target = *theta_target;
    return theta_target.has_value();
  }
  void step() {
    paper_step(chain_, parameters_, x_T_, x_T_velocity_, state_);
    x_T_ += x_T_velocity_;
  }

  const Chain& chain() const { return chain_; }
  const JointVector& theta() const { return state_.theta; }
  const PaperState& state() const { return state_; }
  JointVector weights() const { return paper_weights(chain_, parameters_, state_.theta); }

 private:
  Chain chain_;
  PaperParameters parameters_;
  MultiStartIk search_;
  PaperState state_;
  Eigen::Vector3d x_T_, x_T_velocity_;
};

}  // namespace

void bind_paper_law(py::module_& module) {
  py::class_<PaperLaw>(
      module, "PaperLaw",
      R"(Eqs. (19)-(28) of Hersch & Billard (2008) as printed, for one arm and comparison with the paper.

Parameters, by keyword: gamma (350 rad^2/m^2), alpha (0.08) and beta (0.03, which overshoots) per step, limit_avoidance
(False: the weight of every joint is gamma instead of Eq. (28)). The law keeps no limits of velocity or acceleration, and
may stop short of a target, at spurious attractors (docs/equations.md): GuardedLaw is the one to use.)")
      .def(py::init<const Chain&, double, double, double, bool>(), py::arg("chain"), py::kw_only(),
           py::arg("gamma") = 350.0, py::arg("alpha") = 0.08, py::arg("beta") = 0.03, py::arg("limit_avoidance") = true)
      .def("__copy__", [](const PaperLaw& law) { return PaperLaw(law); })
      .def("__deepcopy__", [](const PaperLaw& law, const py::dict&) { return PaperLaw(law); })
      .def_property_readonly("chain", &PaperLaw::chain, py::return_value_policy::reference_internal)
      .def(
          "start", [](PaperLaw& law, const Doubles& theta) { law.start(joints_of(law.chain(), theta, "theta")); },
          py::arg("theta"), "Puts the arm at rest at theta, rad or m, with theta as its target posture.")
      .def(
          "set_target",
          [](PaperLaw& law, const Doubles& position, const Doubles& velocity,
             const std::optional<Doubles>& theta_target) {
            return law.set_target(
                vector3_of(position, "position"), vector3_of(velocity, "velocity"),
                theta_target ? std::optional(joints_of(law.chain(), *theta_target, "theta_target")) : std::nullopt);
          },
          py::arg("position"), py::arg("velocity") = std::vector<double>(3, 0.0), py::arg("theta_target") = py::none(),
          R"(Sets the hand's target: position x_T (m, in W) and velocity (m per step).

theta_target: the target posture theta_T; default: the IK solution nearest to the arm. False if there is none: theta_T then
stays as it is.)")
      .def(
          "step",
          [](PaperLaw& law, int count) {
            for (int i = 0; i < count; ++i) law.step();
          },
          py::arg("count") = 1, "Integration steps.")
      .def(
          "run", [](PaperLaw& law, int steps, int every) { return trajectory_of(law, steps, every); }, py::arg("steps"),
          py::arg("every") = 1,
          "Integration steps; the joint positions after each `every`-th: shape (steps // every, n).")
      .def_property_readonly(
          "theta", [](const PaperLaw& law) { return array_of(law.state().theta); }, "Joint positions, shape (n,).")
      .def_property_readonly(
          "velocity", [](const PaperLaw& law) { return array_of(law.state().theta_dot); }, "Per step, rad or m.")
      .def_property_readonly(
          "theta_target", [](const PaperLaw& law) { return array_of(law.state().theta_target); },
          "The target posture theta_T, which Eq. (27) moves.")
      .def_property_readonly(
          "x", [](const PaperLaw& law) { return array_of(law.state().x); }, "The hand's position in W, m.")
      .def_property_readonly(
          "weights", [](const PaperLaw& law) { return array_of(law.weights()); },
          "w_x / w_theta of each joint at theta, Eq. (28), rad^2/m^2.");
}

}  // namespace multireach::python
