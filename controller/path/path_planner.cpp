#include "controller/path/path_planner.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::controller {
namespace {

/// gamma * reach^2 of both passes: the first spreads the joints' motion, the second straightens the hand's path. The
/// law's default is 8.5.
constexpr std::array<double, 2> kGamma = {42.5, 425};
/// Largest number of optimisation steps in a pass.
constexpr int kMaxSteps = 25;
/// Distance of the knots from the joint limits, rad (m): nearer to a limit a joint moves slowly.
constexpr double kMargin = 0.03;
/// A path whose length is below this multiple of the distance is good enough.
constexpr double kStraightEnough = 1.05;
/// First guesses in all; the later ones are random.
constexpr int kGuesses = 8;
/// Samples of the hand's position between two knots, to measure a path.
constexpr int kSamples = 8;
/// Work, in optimisation steps, of a first guess with inverse kinematics, and of measuring a path.
constexpr int kGuessWork = 2, kMeasureWork = 3;
/// Every how many knots the clearance is computed.
constexpr size_t kClearanceStride = 2;
constexpr uint64_t kStream = 16;  // of random numbers

/// Tolerance of the end of the path, m: that of the inverse kinematics.
constexpr double kEndTolerance = 1e-7;

}  // namespace

PathPlanner::PathPlanner(const Chain& chain, const std::array<double, kMaxJoints>& mobility,
                         const LevenbergMarquardtIk& solver)
    : chain_(chain),
      solver_(solver),
      optimizer_(chain, mobility),
      links_(chain),
      reach_(std::max(chain.reach(), 1e-6)),
      mobility_(mobility) {}

void PathPlanner::begin(const JointVector& start, const Eigen::Vector3d& target, const JointVector& theta_target) {
  start_ = start;
  target_ = target;
  theta_target_ = theta_target;
  distance_ = (chain_.position(start) - target).norm();
  stage_ = Stage::kGuess;
  guesses_ = pass_ = steps_ = owed_ = 0;
  found_ = false;
}

void PathPlanner::advance(int work, Proximity& proximity) {
  owed_ += work;
  while (owed_ > 0 && stage_ != Stage::kFinished) owed_ -= work_once(proximity);
}

int PathPlanner::work_once(Proximity& proximity) {
  switch (stage_) {
    case Stage::kGuess: {
      const int work = guesses_ < 2 ? 0 : kGuessWork;
      if ((found_ && best_length_ < kStraightEnough * distance_) || guesses_ == kGuesses) {
        stage_ = Stage::kFinished;
      } else if (guess()) {
        pass_ = steps_ = 0;
        optimizer_.begin(candidate_, target_, kGamma[0] / (reach_ * reach_), kMargin);
        stage_ = Stage::kOptimize;
      }
      ++guesses_;
      return work;
    }
    case Stage::kOptimize:
      if (!optimizer_.improve() || ++steps_ >= kMaxSteps) stage_ = Stage::kMeasure;
      return 1;
    case Stage::kMeasure:
      if (measure()) {
        checked_ = 0;
        stage_ = Stage::kCheckClearance;
      } else {
        end_pass();
      }
      return kMeasureWork;
    case Stage::kCheckClearance:
      if (checked_ < JointPath::kSegments && !proximity.nothing_to_avoid()) {
        checked_ += kClearanceStride;
        if (proximity.clearance(candidate_.knot(checked_, chain_.size())) < 0) end_pass();
        return 1;
      }
      best_ = candidate_;
      best_length_ = candidate_length_;
      found_ = true;
      end_pass();
      return 0;
    case Stage::kFinished:
      break;
  }
  return 0;
}

bool PathPlanner::guess() {
  constexpr size_t kEnd = JointPath::kSegments, kMiddle = kEnd / 2;
  if (guesses_ == 0) {
    candidate_.set_line(0, kEnd, start_, theta_target_);
    return true;
  }
  // Another posture: in the middle of the joints' ranges, then random; continuous joints relative to the start. Heavy
  // and locked joints stay where they are.
  JointVector other(chain_.size()), end = theta_target_;
  const CounterRandom random(kStream, static_cast<uint64_t>(guesses_));
  for (int i = 0; i < chain_.size(); ++i) {
    const double share = guesses_ < 3 ? 0.5 : random.uniform(static_cast<uint64_t>(i));
    const double low = chain_.sample_lower(i), high = chain_.sample_upper(i);
    if (mobility_[i] < PathOptimizer::kHeavyMobility) {
      other[i] = start_[i];
      continue;
    }
    other[i] = chain_.joint(i).limited() ? low + share * (high - low) : start_[i] + (share - 0.5) * (high - low);
  }
  if (guesses_ > 1) {
    end = other;
    if (solver_.solve({.position = target_}, end, kEndTolerance) > kEndTolerance) return false;
  }
  if (guesses_ == 2) {
    candidate_.set_line(0, kEnd, start_, end);
  } else {
    candidate_.set_line(0, kMiddle, start_, other);
    candidate_.set_line(kMiddle, kEnd, other, end);
  }
  return true;
}

bool PathPlanner::measure() {
  const int n = chain_.size();
  candidate_ = optimizer_.path();
  JointVector end = candidate_.knot(JointPath::kSegments, n);
  if (solver_.solve({.position = target_}, end, kEndTolerance) > kEndTolerance) return false;
  candidate_.set_knot(JointPath::kSegments, end);
  FastHand<double, kMaxJoints> hand;
  std::array<double, kMaxJoints> theta;
  std::array<double, 3> before{};
  candidate_length_ = 0;
  for (size_t k = 0; k < JointPath::kSegments; ++k) {
    for (int sample = k == 0 ? 0 : 1; sample <= kSamples; ++sample) {
      const double share = static_cast<double>(sample) / kSamples;
      for (int i = 0; i < n; ++i) {
        theta[i] = candidate_.knots[k][i] + share * (candidate_.knots[k + 1][i] - candidate_.knots[k][i]);
      }
      forward_kinematics<false>(links_, n, theta, hand);
      double sum = 0;
      for (size_t m = 0; m < 3; ++m) {
        sum += (hand.position[m] - before[m]) * (hand.position[m] - before[m]);
        before[m] = hand.position[m];
      }
      if (k > 0 || sample > 0) candidate_length_ += std::sqrt(sum);
    }
  }
  return !found_ || candidate_length_ < best_length_;
}

void PathPlanner::end_pass() {
  steps_ = 0;
  if (++pass_ < static_cast<int>(kGamma.size())) {
    optimizer_.begin(optimizer_.path(), target_, kGamma[static_cast<size_t>(pass_)] / (reach_ * reach_), kMargin);
    stage_ = Stage::kOptimize;
  } else {
    stage_ = Stage::kGuess;
  }
}

}  // namespace multireach::controller
