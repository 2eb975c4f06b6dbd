#include "kinematics/chain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "kinematics/joint_frames.hpp"

namespace multireach {
namespace {

std::string number(double value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.9g", value);
  return text.data();
}

}  // namespace

namespace {
constexpr double kTwoTurns = 4 * std::numbers::pi;
}

Chain::Chain(std::vector<Joint> joints, std::vector<Eigen::Isometry3d> fixed, std::string base, std::string tip)
    : joints_(std::move(joints)), fixed_(std::move(fixed)), base_(std::move(base)), tip_(std::move(tip)) {
  const std::string where = "the chain from '" + base_ + "' to '" + tip_ + "'";
  if (joints_.empty()) throw std::invalid_argument(where + " has no moving joint");
  if (joints_.size() > kMaxJoints) {
    throw std::invalid_argument(where + " has " + std::to_string(joints_.size()) + " joints; at most " +
                                std::to_string(kMaxJoints) + " are supported");
  }
  if (fixed_.size() != joints_.size() + 1)
    throw std::invalid_argument(where + " needs one fixed transform more than joints");
  lower_.resize(size());
  upper_.resize(size());
  velocity_.resize(size());
  for (int i = 0; i < size(); ++i) {
    const Joint& joint = joints_[i];
    if (!(std::abs(joint.axis.norm() - 1) < 1e-9)) {
      throw std::invalid_argument("joint '" + joint.name + "' has an axis that is not a unit vector");
    }
    if (joint.limited() && !(std::isfinite(joint.lower) && std::isfinite(joint.upper))) {
      throw std::invalid_argument("joint '" + joint.name + "' has a limit that is not finite");
    }
    if (!(joint.velocity >= 0)) {
      throw std::invalid_argument("joint '" + joint.name + "' has a largest speed that is not 0 or more");
    }
    if (joint.limited() && !(joint.lower <= joint.upper)) {
      throw std::invalid_argument("joint '" + joint.name + "' has its lower limit above its upper limit");
    }
    const double infinity = std::numeric_limits<double>::infinity();
    lower_[i] = joint.limited() ? joint.lower : -infinity;
    upper_[i] = joint.limited() ? joint.upper : infinity;
    velocity_[i] = joint.velocity;
  }
}

int Chain::index_of(std::string_view joint_name) const {
  const auto found = std::ranges::find(joints_, joint_name, &Joint::name);
  return found == joints_.end() ? -1 : static_cast<int>(found - joints_.begin());
}

namespace {

struct AxesInWorld {
  std::array<Eigen::Vector3d, kMaxJoints> axis, origin;
  void operator()(int i, const Eigen::Vector3d& axis_W, const Eigen::Vector3d& p_WJ, const Eigen::Isometry3d&) {
    axis[i] = axis_W;
    origin[i] = p_WJ;
  }
};

}  // namespace

Eigen::Vector3d Chain::position(const JointVector& theta) const {
  return pose(theta).translation();
}

Eigen::Isometry3d Chain::pose(const JointVector& theta) const {
  return visit_joints(*this, theta, [](auto&&...) {});
}

void Chain::position_and_jacobian(const JointVector& theta, Eigen::Vector3d& p_WT, PositionJacobian& jacobian) const {
  AxesInWorld axes;
  p_WT = visit_joints(*this, theta, axes).translation();
  jacobian.resize(3, size());
  for (int i = 0; i < size(); ++i) {
    jacobian.col(i) =
        joints_[i].type == Joint::Type::kPrismatic ? axes.axis[i] : axes.axis[i].cross(p_WT - axes.origin[i]).eval();
  }
}

void Chain::pose_and_jacobian(const JointVector& theta, Eigen::Isometry3d& X_WT, PoseJacobian& jacobian) const {
  AxesInWorld axes;
  X_WT = visit_joints(*this, theta, axes);
  jacobian.resize(6, size());
  for (int i = 0; i < size(); ++i) {
    if (joints_[i].type == Joint::Type::kPrismatic) {
      jacobian.col(i) << axes.axis[i], Eigen::Vector3d::Zero();
    } else {
      jacobian.col(i) << axes.axis[i].cross(X_WT.translation() - axes.origin[i]), axes.axis[i];
    }
  }
}

double Chain::limit_excess(const JointVector& theta) const {
  double excess = 0;
  for (int i = 0; i < size(); ++i) excess = std::max({excess, lower_[i] - theta[i], theta[i] - upper_[i]});
  return excess;
}

double Chain::reach() const {
  double reach = 0;
  for (int i = 0; i < size(); ++i) {
    reach += fixed_[i + 1].translation().norm();
    if (joints_[i].type == Joint::Type::kPrismatic) reach += std::max(std::abs(lower_[i]), std::abs(upper_[i]));
  }
  return reach;
}

JointVector Chain::clamped(const JointVector& theta) const {
  return theta.cwiseMax(lower_).cwiseMin(upper_);
}

double Chain::sample_lower(int i) const {
  if (!joints_[i].limited()) return -std::numbers::pi;
  return has_multi_turn_range(i) ? std::clamp(-kTwoTurns, lower_[i], upper_[i] - 2 * kTwoTurns) : lower_[i];
}
double Chain::sample_upper(int i) const {
  if (!joints_[i].limited()) return std::numbers::pi;
  return has_multi_turn_range(i) ? sample_lower(i) + 2 * kTwoTurns : upper_[i];
}
bool Chain::has_multi_turn_range(int i) const {
  return joints_[i].type == Joint::Type::kRevolute && upper_[i] - lower_[i] > 2 * kTwoTurns;
}

std::optional<std::string> joint_configuration_fault(const Chain& chain, const std::vector<double>& theta,
                                                     std::string_view what, double tolerance) {
  const std::string whose(what);
  if (static_cast<int>(theta.size()) != chain.size()) {
    std::string names;
    for (const Joint& joint : chain.joints()) names += (names.empty() ? "" : ", ") + joint.name;
    return whose + " has " + std::to_string(theta.size()) + " values; the chain from '" + chain.base() + "' to '" +
           chain.tip() + "' has " + std::to_string(chain.size()) + " joints (" + names + ")";
  }
  for (int i = 0; i < chain.size(); ++i) {
    const Joint& joint = chain.joint(i);
    if (!std::isfinite(theta[i])) return whose + ": the value of joint '" + joint.name + "' is not a finite number";
    if (theta[i] < chain.lower()[i] - tolerance || theta[i] > chain.upper()[i] + tolerance) {
      return whose + ": joint '" + joint.name + "' is at " + number(theta[i]) + ", outside its limits " +
             number(joint.lower) + " to " + number(joint.upper);
    }
  }
  return std::nullopt;
}

}  // namespace multireach
