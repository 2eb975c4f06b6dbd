#pragma once

#include <memory>
#include <optional>
#include <string>

#include "controller/ik/posture_search.hpp"
#include "controller/law/guarded_law.hpp"
#include "controller/law/paper_law.hpp"
#include "studies/figures/motion.hpp"

namespace multireach {

/// Integration steps per second of all figures, Sect. 4.
inline constexpr double kStepsPerSecond = 140;

/// Joint angles of a scene that is made for the Hoap2, from degrees. Throws std::invalid_argument for another arm.
JointVector hoap2_posture(const Chain& chain, std::initializer_list<double> degrees);

/// One arm under one law, at rest at first.
class LawRun {
 public:
  virtual ~LawRun() = default;
  /// A new target (m, in W), for which theta_T is chosen anew. Throws std::invalid_argument when no posture reaches it.
  virtual void aim(const Eigen::Vector3d& x_T) = 0;
  virtual void step() = 0;
  /// Where it is at `time`.
  virtual Moment moment(double time) const = 0;
  /// w_x / w_theta, rad^2/m^2.
  virtual JointVector weights() const = 0;
};

/// The law `paper`: literal, with theta_T chosen again as in Sect. 3.4.
class PaperRun final : public LawRun {
 public:
  /// theta_T is chosen anew when K(theta_T) is further than `rechoose_m` from the target; infinity for never.
  PaperRun(const Chain& chain, const controller::PaperParameters& parameters, const JointVector& start,
           double rechoose_m = 0.01);
  void aim(const Eigen::Vector3d& x_T) override;
  void step() override;
  /// Puts the arm elsewhere (rad), with the velocity that it has.
  void displace(const JointVector& by);
  Moment moment(double time) const override;
  JointVector weights() const override;
  int64_t posture_choices() const { return posture_choices_; }

 private:
  Chain chain_;
  controller::PaperParameters parameters_;
  controller::PostureSearch search_;
  double rechoose_m_;
  controller::PaperState state_;
  Eigen::Vector3d target_;
  int64_t posture_choices_ = 0;
};

/// A law as the controller runs it.
class ReachingLawRun final : public LawRun {
 public:
  ReachingLawRun(std::unique_ptr<controller::ReachingLaw> law, const JointVector& start);
  void aim(const Eigen::Vector3d& x_T) override;
  void step() override { law_->step(); }
  Moment moment(double time) const override;
  JointVector weights() const override { return law_->weights(); }

 private:
  std::unique_ptr<controller::ReachingLaw> law_;
};

/// The law `guarded` as robots/hoap2/robot.yaml configures it (60 rad/s^2), with the gamma of the figure.
std::unique_ptr<LawRun> guarded_run(const Chain& chain, double gamma, const JointVector& start);
/// The law `paper` as it runs live: with theta_T watched over, which stays inside the limits.
std::unique_ptr<LawRun> watched_paper_run(const Chain& chain, const controller::PaperParameters& parameters,
                                          const JointVector& start);

/// One of the two.
std::unique_ptr<LawRun> law_run(const Chain& chain, bool paper, double gamma, const JointVector& start);

/// What guarded_run is made with.
controller::GuardedParameters guarded_parameters(const Chain& chain, double gamma);

/// `seconds` of a run, from the moment where it is, which has the time `from`.
Motion record(LawRun& run, double seconds, double from = 0);

}  // namespace multireach
