#include "bench/ik_solvers.hpp"

#include <Eigen/SVD>
#include <cmath>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainiksolverpos_nr_jl.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <memory>
#include <numbers>

#include "bench/kdl_chain.hpp"
#include "controller/ik/multi_start.hpp"
#include "controller/law/guarded_law.hpp"
#include "numeric/random.hpp"

namespace multireach::bench {
namespace {

using controller::GuardedLaw;
using controller::MultiStartIk;
using controller::TaskKind;
using controller::TaskTarget;

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kStepsPerSecond = 140, kMaxSeconds = 20;
constexpr double kStill = 1e-6;  // rad (m) per step; the arm rests below this speed

/// A KDL solver, together with the chain that it refers to.
class KdlPositionSolver {
 public:
  virtual ~KdlPositionSolver() = default;
  virtual void solve(const KDL::JntArray& from, const KDL::Frame& to, KDL::JntArray& found) = 0;
};

class Lma final : public KdlPositionSolver {
 public:
  Lma(const Chain& chain, TaskKind task)
      : arm_(kdl_chain(chain)),
        // The same weights as in the project's task: 1 rad counts as 0.1 m. The tolerance is on the weighted norm.
        solver_(arm_,
                task == TaskKind::kPose ? Eigen::Matrix<double, 6, 1>(1, 1, 1, 0.1, 0.1, 0.1)
                                        : Eigen::Matrix<double, 6, 1>(1, 1, 1, 0, 0, 0),
                task == TaskKind::kPose ? 0.1 * kIkTolerance : kIkTolerance) {}
  void solve(const KDL::JntArray& from, const KDL::Frame& to, KDL::JntArray& found) override {
    solver_.CartToJnt(from, to, found);
  }

 private:
  KDL::Chain arm_;
  KDL::ChainIkSolverPos_LMA solver_;
};

/// Forward kinematics without the rotation, so that KDL's Newton-Raphson, whose task always has six rows, considers the
/// position only.
class PositionOnlyFk final : public KDL::ChainFkSolverPos {
 public:
  explicit PositionOnlyFk(const KDL::Chain& arm) : whole_(arm) {}
  int JntToCart(const KDL::JntArray& q, KDL::Frame& frame, int segment) override {
    const int code = whole_.JntToCart(q, frame, segment);
    frame.M = KDL::Rotation::Identity();
    return code;
  }
  int JntToCart(const KDL::JntArray&, std::vector<KDL::Frame>&, int) override { return E_NOT_IMPLEMENTED; }
  void updateInternalDataStructures() override { whole_.updateInternalDataStructures(); }

 private:
  KDL::ChainFkSolverPos_recursive whole_;
};

/// Like KDL's ChainIkSolverVel_pinv, for the three rows of the position.
class PositionOnlyPinv final : public KDL::ChainIkSolverVel {
 public:
  explicit PositionOnlyPinv(const KDL::Chain& arm) : jacobians_(arm), jacobian_(arm.getNrOfJoints()) {}
  int CartToJnt(const KDL::JntArray& q, const KDL::Twist& twist, KDL::JntArray& v) override {
    constexpr double kSmallest = 1e-5;  // singular values below it are ignored, as in KDL
    jacobians_.JntToJac(q, jacobian_);
    const Eigen::Matrix<double, 3, Eigen::Dynamic> J = jacobian_.data.topRows<3>();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeThinU | Eigen::ComputeThinV);
    Eigen::Vector3d along = svd.matrixU().transpose() * Eigen::Vector3d(twist.vel.data);
    for (int k = 0; k < 3; ++k) along[k] *= svd.singularValues()[k] < kSmallest ? 0 : 1 / svd.singularValues()[k];
    v.data = svd.matrixV() * along;
    return E_NOERROR;
  }
  int CartToJnt(const KDL::JntArray&, const KDL::FrameVel&, KDL::JntArrayVel&) override { return E_NOT_IMPLEMENTED; }
  void updateInternalDataStructures() override { jacobians_.updateInternalDataStructures(); }

 private:
  KDL::ChainJntToJacSolver jacobians_;
  KDL::Jacobian jacobian_;
};

KDL::JntArray limits_of(const JointVector& limits) {
  constexpr double kAnywhere = 1e9;
  KDL::JntArray array(static_cast<unsigned>(limits.size()));
  array.data = limits.cwiseMax(-kAnywhere).cwiseMin(kAnywhere);
  return array;
}

template <class Forward, class Velocities>
class NewtonRaphson final : public KdlPositionSolver {
 public:
  explicit NewtonRaphson(const Chain& chain)
      : arm_(kdl_chain(chain)),
        forward_(arm_),
        velocities_(arm_),
        // KDL applies the tolerance to each row.
        solver_(arm_, limits_of(chain.lower()), limits_of(chain.upper()), forward_, velocities_, 100,
                0.5 * kIkTolerance) {}
  void solve(const KDL::JntArray& from, const KDL::Frame& to, KDL::JntArray& found) override {
    solver_.CartToJnt(from, to, found);
  }

 private:
  KDL::Chain arm_;
  Forward forward_;
  Velocities velocities_;
  KDL::ChainIkSolverPos_NR_JL solver_;
};

KDL::Frame frame_of(const TaskTarget& target) {
  const Eigen::Vector3d& p = target.position;
  KDL::Rotation R = KDL::Rotation::Identity();
  if (target.task == TaskKind::kPose) {
    const Eigen::Quaterniond q(target.orientation);
    R = KDL::Rotation::Quaternion(q.x(), q.y(), q.z(), q.w());
  }
  return {R, KDL::Vector(p.x(), p.y(), p.z())};
}

/// `starts` 1: the plain solver. More: restarts from random configurations, the same for every target.
IkSolver wrapped(const Chain& chain, const std::string& name, std::shared_ptr<KdlPositionSolver> solver, int starts) {
  const auto solve = [chain, solver, starts](const TaskTarget& target, const JointVector& start) {
    const CounterRandom random(1);
    const KDL::Frame goal = frame_of(target);
    const auto n = static_cast<unsigned>(chain.size());
    KDL::JntArray from(n), found(n);
    from.data = start;
    uint64_t counter = 0;
    for (int k = 1;; ++k) {
      solver->solve(from, goal, found);
      if (k >= starts) break;
      const JointVector posture = unwound(chain, found.data);
      if (inside_limits(chain, posture) && meets(chain, target, posture)) break;
      for (int i = 0; i < chain.size(); ++i) {
        from(static_cast<unsigned>(i)) = random.uniform(counter++, chain.sample_lower(i), chain.sample_upper(i));
      }
    }
    return IkAnswer{found.data, 0};
  };
  return {.name = starts > 1 ? name + ", again" : name, .solve = solve, .moves = false};
}

IkAnswer run_to_rest(GuardedLaw& law, const TaskTarget& target, const JointVector& start) {
  law.start(start);
  law.set_target(target);
  int steps = 0;
  for (bool rests = false; !rests && steps < kMaxSeconds * kStepsPerSecond; ++steps) {
    law.step();
    rests = law.velocity().cwiseAbs().maxCoeff() < kStill && (law.x() - target.position).norm() <= kIkTolerance &&
            meets(law.chain(), target, law.theta());
  }
  return {law.theta(), steps / kStepsPerSecond};
}

}  // namespace

bool meets(const Chain& chain, const TaskTarget& target, const JointVector& posture) {
  if (!posture.allFinite()) return false;
  const Eigen::Isometry3d X = chain.pose(posture);
  if (!((X.translation() - target.position).norm() <= kIkTolerance)) return false;
  if (target.task != TaskKind::kPose) return true;
  return Eigen::AngleAxisd(X.linear().transpose() * target.orientation).angle() <= kIkTolerance;
}

JointVector unwound(const Chain& chain, JointVector posture) {
  if (!posture.allFinite()) return posture;
  for (int i = 0; i < chain.size(); ++i) {
    if (chain.joint(i).type != Joint::Type::kRevolute) continue;
    const double middle = 0.5 * (chain.lower()[i] + chain.upper()[i]);
    const double turned = posture[i] - kTurn * std::round((posture[i] - middle) / kTurn);
    const bool inside = turned >= chain.lower()[i] && turned <= chain.upper()[i];
    if (inside && (posture[i] < chain.lower()[i] || posture[i] > chain.upper()[i])) posture[i] = turned;
  }
  return posture;
}

bool inside_limits(const Chain& chain, const JointVector& posture) {
  return posture.allFinite() && chain.limit_excess(posture) <= 1e-9;
}

std::vector<IkSolver> own_solvers(const Chain& chain) {
  const auto search = std::make_shared<MultiStartIk>(chain);
  const auto law = std::make_shared<GuardedLaw>(chain);
  return {
      {.name = "nearest",
       .solve =
           [search](const TaskTarget& target, const JointVector& start) {
             return IkAnswer{search->best(target, start).theta, 0};
           },
       .moves = false},
      {.name = "first",
       .solve =
           [search](const TaskTarget& target, const JointVector& start) {
             return IkAnswer{search->first(target, start).theta, 0};
           },
       .moves = false},
      {.name = "moving",
       .solve = [law](const TaskTarget& target, const JointVector& start) { return run_to_rest(*law, target, start); },
       .moves = true}};
}

std::vector<IkSolver> kdl_solvers(const Chain& chain, TaskKind task) {
  const auto lma = std::make_shared<Lma>(chain, task);
  std::shared_ptr<KdlPositionSolver> newton;
  if (task == TaskKind::kPose) {
    newton = std::make_shared<NewtonRaphson<KDL::ChainFkSolverPos_recursive, KDL::ChainIkSolverVel_pinv>>(chain);
  } else {
    newton = std::make_shared<NewtonRaphson<PositionOnlyFk, PositionOnlyPinv>>(chain);
  }
  return {wrapped(chain, "LMA", lma, 1), wrapped(chain, "LMA", lma, kMaxStarts), wrapped(chain, "NR_JL", newton, 1),
          wrapped(chain, "NR_JL", newton, kMaxStarts)};
}

}  // namespace multireach::bench
