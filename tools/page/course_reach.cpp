// Step 6 of the set-up course: the arm reaches for the object.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/page/course_step.hpp"

namespace multireach {
namespace {

constexpr int64_t kRest = 600000;  // us, of the robot's time: so long the hand must rest
constexpr int64_t kLongRest =
    5000000;  // us: the same where it is not yet where the object is seen, but may only wait for set-points
constexpr int64_t kLeastTime = 1000000;  // us, at each place
constexpr double kSamePlace = 1e-6;      // m
constexpr double kResting = 0.0003;      // m
constexpr double kArrived = 0.001;       // m
constexpr double kNear = 0.02;           // m: where the hand rests nearer than this to the target, it has reached it
constexpr double kGood = 0.003,
                 kGoodReal = 0.005;  // m: of a reach that is good; with real cameras the truth is not known
// Practice: where the ball is held, m, in W.
const std::array<Eigen::Vector3d, 3> kPlaces{Eigen::Vector3d(0.10, -0.12, 0.10), Eigen::Vector3d(0.06, -0.20, 0.10),
                                             Eigen::Vector3d(0.11, -0.15, 0.04)};

class ReachStep : public CourseStep {
 public:
  const char* name() const override { return "reach"; }
  bool done() const override { return done_; }

  void begin(CourseContext& context, const json&) override {
    again(context);
    active_ = true;
    practice_ = context.practice;
    context.touch.choose(target_choice_t::CONFIGURED, "the set-up course", context.now_us, *context.out);
    show_place(context);
  }
  void again(CourseContext&) override {
    done_ = active_ = false;
    errors_mm_.clear();
    seen_mm_.clear();
    rest_.reset();
    target_.reset();
    truth_.reset();
    distance_mm_ = -1;
  }
  void leave(CourseContext&) override { active_ = false; }
  bool ended() const override { return !active_; }

  void target(const target_t& target, CourseContext&) override {
    if (practice_ && (!shown_utime_ || target.utime < *shown_utime_)) return;  // images of the place before
    reason_ = target.status == target_t::STATUS_TRACKED ? "" : target.reason;
    target_.reset();
    if (reason_.empty()) target_ = Eigen::Map<const Eigen::Vector3d>(target.position_m);
  }
  void truth(const target_t& truth, CourseContext&) override {
    truth_.reset();
    if (truth.status != target_t::STATUS_TRACKED) return;
    const Eigen::Vector3d position = Eigen::Map<const Eigen::Vector3d>(truth.position_m);
    if ((position - place()).norm() > kSamePlace) return;
    truth_ = position;
    if (!shown_utime_) shown_utime_ = truth.utime;
  }

  void robot(const JointVector& theta, int64_t utime, CourseContext& context) override {
    if (!active_ || done_) return;
    const Eigen::Vector3d hand = context.robot.chain.position(theta);
    if (!begun_utime_ || utime < *begun_utime_) begun_utime_ = utime;
    if (!rest_ || utime < rest_->first || (rest_->second - hand).norm() > kResting) rest_.emplace(utime, hand);
    if (!target_) return;
    distance_mm_ = 1e3 * (hand - *target_).norm();
    const int64_t needed = distance_mm_ > 1e3 * kArrived ? kLongRest : kRest;
    const bool rests = utime - *begun_utime_ > kLeastTime && utime - rest_->first > needed;
    if (!rests || distance_mm_ > 1e3 * kNear || (practice_ && !truth_)) return;
    errors_mm_.push_back(1e3 * (hand - (practice_ ? *truth_ : *target_)).norm());
    seen_mm_.push_back(distance_mm_);
    if (errors_mm_.size() < (practice_ ? kPlaces.size() : 1)) return show_place(context);
    done_ = worst() <= 1e3 * (practice_ ? kGood : kGoodReal);
    active_ = false;
  }

  std::string text() const override {
    const std::string measured = errors_mm_.empty() ? "" : result();
    if (done_) return measured + " The set-up is complete.";
    if (!active_ && !errors_mm_.empty())
      return measured + fmt::format(" That is too much: at most {:.0f} mm were expected. Do the step 'pose' again.",
                                    1e3 * (practice_ ? kGood : kGoodReal));
    if (!active_) return "Take the object out of the hand, hold it where the arm can reach it, and begin.";
    if (!reason_.empty()) return "Vision does not see the object: " + reason_ + ".";
    if (distance_mm_ < 0) return "Waiting for the target and the robot.";
    return fmt::format("The hand is {:.1f} mm from the object.", distance_mm_);
  }
  json details() const override {
    return {{"distance_mm", distance_mm_}, {"errors_mm", errors_mm_}, {"seen_mm", seen_mm_}};
  }

 private:
  double worst() const { return *std::ranges::max_element(errors_mm_); }
  /// What is left of the distance from where the object is seen is the arm's error; the rest is that of cameras and
  /// vision.
  std::string result() const {
    if (!practice_) return fmt::format("The hand rests {:.1f} mm from the object (as seen).", worst());
    const auto at = static_cast<size_t>(std::ranges::max_element(errors_mm_) - errors_mm_.begin());
    return fmt::format(
        "The hand rests {:.1f} mm from the object (the truth, at most), {:.1f} mm from where it is seen.", worst(),
        seen_mm_[at]);
  }
  const Eigen::Vector3d& place() const { return kPlaces[errors_mm_.size() % kPlaces.size()]; }
  void show_place(CourseContext& context) {
    context.show(practice_scene_t::BALL, place());
    shown_utime_.reset();
    begun_utime_.reset();
    rest_.reset();
    target_.reset();
    truth_.reset();
  }

  bool done_ = false, active_ = false, practice_ = false;
  std::optional<Eigen::Vector3d> target_, truth_;
  std::optional<int64_t> begun_utime_, shown_utime_;         // by the clocks of the robot and of the cameras
  std::optional<std::pair<int64_t, Eigen::Vector3d>> rest_;  // since when the hand rests, and where
  std::vector<double> errors_mm_, seen_mm_;  // at each place, from the truth (practice) and from where it is seen
  double distance_mm_ = -1;
  std::string reason_;
};

}  // namespace

std::unique_ptr<CourseStep> reach_step() {
  return std::make_unique<ReachStep>();
}

}  // namespace multireach
