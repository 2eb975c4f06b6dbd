#pragma once

#include <memory>
#include <optional>
#include <string>

#include "controller/ik/multi_start.hpp"
#include "controller/law/guarded_law.hpp"
#include "controller/law/paper_law.hpp"
#include "studies/figures/motion.hpp"

namespace multireach {

/// Integration steps per second in all figures, Sect. 4.
inline constexpr double kStepsPerSecond = 140;

/// Joint angles (rad) of the Hoap2, from degrees. Throws std::invalid_argument for any other arm.
JointVector hoap2_posture(const Chain& chain, std::initializer_list<double> degrees);

/// One arm under one law, initially at rest.
class LawRun {
 public:
  virtual ~LawRun() = default;
  /// Sets a new target (m, in W) and searches theta_T. Throws std::invalid_argument when the target is unreachable.
  virtual void set_target(const Eigen::Vector3d& x_T) = 0;
  virtual void step() = 0;
  /// The current state, with `time` (s) as its time.
  virtual Moment moment(double time) const = 0;
  /// w_x / w_theta, rad^2/m^2.
  virtual JointVector weights() const = 0;
};

/// The law `paper` as printed, with theta_T searched again as in Sect. 3.4.
class PaperRun final : public LawRun {
 public:
  /// theta_T is searched again when K(theta_T) is further than `drift_m` from the target; infinity for never.
  PaperRun(const Chain& chain, const controller::PaperParameters& parameters, const JointVector& start,
           double drift_m = 0.01);
  void set_target(const Eigen::Vector3d& x_T) override;
  void step() override;
  /// Displaces the arm (rad) without changing its velocity.
  void displace(const JointVector& by);
  Moment moment(double time) const override;
  JointVector weights() const override;
  int64_t ik_searches() const { return ik_searches_; }

 private:
  Chain chain_;
  controller::PaperParameters parameters_;
  controller::MultiStartIk search_;
  double drift_m_;
  controller::PaperState state_;
  Eigen::Vector3d target_;
  int64_t ik_searches_ = 0;
};

/// Runs a law through the ReachingLaw interface, as the controller does.
class ReachingLawRun final : public LawRun {
 public:
  ReachingLawRun(std::unique_ptr<controller::ReachingLaw> law, const JointVector& start);
  void set_target(const Eigen::Vector3d& x_T) override;
  void step() override { law_->step(); }
  Moment moment(double time) const override;
  JointVector weights() const override { return law_->weights(); }

 private:
  std::unique_ptr<controller::ReachingLaw> law_;
};

/// The law `guarded` as configured in robots/hoap2/robot.yaml (60 rad/s^2), with the figure's gamma.
std::unique_ptr<LawRun> guarded_run(const Chain& chain, double gamma, const JointVector& start);
/// The law `paper` as it runs live: supervised, with theta_T inside the joint limits.
std::unique_ptr<LawRun> supervised_paper_run(const Chain& chain, const controller::PaperParameters& parameters,
                                             const JointVector& start);

/// supervised_paper_run() or guarded_run(), selected by `paper`.
std::unique_ptr<LawRun> law_run(const Chain& chain, bool paper, double gamma, const JointVector& start);

/// The parameters of guarded_run().
controller::GuardedParameters guarded_parameters(const Chain& chain, double gamma);

/// Records `seconds` of a run from its current state, which gets the time `from`.
Motion record(LawRun& run, double seconds, double from = 0);

}  // namespace multireach
