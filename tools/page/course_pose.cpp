// Steps 4 and 5 of the set-up course: where the cameras are, and whether that is right. The robot holds the object and
// moves through safe postures.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "runtime/camera_files.hpp"
#include "runtime/files.hpp"
#include "runtime/rig_config.hpp"
#include "tools/calibrate/hand_eye_output.hpp"
#include "tools/page/course_step.hpp"
#include "tools/page/posture_tour.hpp"
#include "vision/reported_covariance.hpp"

namespace multireach {
namespace {

using nlohmann::json;

const Eigen::Vector3d kPracticeOffset(0.010, 0.004, -0.006);  // m: where the practice's hand holds the ball

/// Covariance of a target's position without the errors of the calibration, which are the same at all positions.
Eigen::Matrix3d covariance_of(const target_t& target, const StereoRig& rig) {
  return vision::measured_covariance(
      rig, {Eigen::Map<const Eigen::Vector3d>(target.position_m),
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&target.covariance_m2[0][0])});
}

json list(const Eigen::Vector3d& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

/// Whether both cameras of `rig` see a point in the left camera's frame, not at the border.
bool in_view(const StereoRig& rig, const Eigen::Vector3d& p_L) {
  const auto inside = [](const CameraModel& camera, const Eigen::Vector3d& p_C) {
    constexpr double kBorder = 0.1, kNearest = 0.05;
    if (p_C.z() < kNearest) return false;
    const Eigen::Vector2d pixel = camera.project(p_C);
    return pixel.x() > kBorder * camera.width && pixel.y() > kBorder * camera.height &&
           pixel.x() < (1 - kBorder) * camera.width && pixel.y() < (1 - kBorder) * camera.height;
  };
  return inside(rig.left, p_L) && inside(rig.right, rig.X_RL * p_L);
}

bool far_from(const std::vector<HandEyeSample>& samples, const Eigen::Isometry3d& X_WH, double distance_m) {
  return std::ranges::all_of(samples, [&](const HandEyeSample& sample) {
    return (sample.X_WH.translation() - X_WH.translation()).norm() > distance_m;
  });
}

/// What both steps do: a tour of postures while the hand holds the target.
class TourStep : public CourseStep {
 public:
  void leave(CourseContext& context) override {
    if (tour_) context.arm.stop();
    tour_.reset();
  }
  bool ended() const override { return !active_; }
  void robot(const JointVector& theta, int64_t, CourseContext& context) override {
    const Eigen::Isometry3d X_WH = context.robot.chain.pose(theta);
    const bool moves = !still_ || (still_->second - X_WH.translation()).norm() > kStill;
    if (moves) still_.emplace(context.now_us, X_WH.translation());
    if (tour_) tour_->hand(X_WH, context.now_us);
  }
  void tick(CourseContext& context) override {
    if (!active_) return;
    obstacle_ = context.arm.obstacle();
    if (!context.arm.theta()) return;
    if (!tour_) tour_.emplace(context.robot, *context.arm.theta(), seed());
    if (!tour_->tick(context.arm, [&](const Eigen::Isometry3d& X_WH) {
          return far_from(tour_->samples(), X_WH, kSpread * context.robot.chain.reach()) && wanted(X_WH);
        })) {
      fault_ = "no further posture near the first one is safe and in view; move the arm elsewhere and begin again";
      finish(context);
    } else {
      progress(context);
    }
  }

 protected:
  static constexpr double kStill = 0.002;  // m: the hand stands still while it stays within this
  static constexpr double kSpread = 0.03;  // of the arm's reach: between two positions of the hand

  virtual uint64_t seed() const = 0;
  virtual bool wanted(const Eigen::Isometry3d& X_WH) const = 0;
  virtual void progress(CourseContext& context) = 0;

  void start(CourseContext& context) {
    context.touch.choose(target_choice_t::NONE, "the set-up course", context.now_us, *context.out);
    context.show(practice_scene_t::HELD, kPracticeOffset);
    active_ = true;
    fault_.clear();
    tour_.reset();
  }
  void finish(CourseContext& context) {
    active_ = false;
    context.arm.stop();
    tour_.reset();
  }
  void measure(const target_t& target, int8_t status, const StereoRig& rig, CourseContext& context) {
    if (!tour_ || is_older_than_standstill(target.utime, context)) return;
    std::optional<Eigen::Vector3d> p;
    if (target.status == status) p = Eigen::Map<const Eigen::Vector3d>(target.position_m);
    reason_ = p ? "" : target.reason;
    tour_->target(p, covariance_of(target, rig), context.now_us, context.arm.arrived());
  }
  /// Under load cameras and vision lag, and images from before a standstill must not count as images of it. The robot's
  /// clock says nothing about them: it may begin at 0, and that of a simulated robot stands still while it lags.
  bool is_older_than_standstill(int64_t utime, const CourseContext& context) const {
    constexpr int64_t kSettling = 300000;  // us
    const auto captured = context.capture_time.of(utime);
    return !still_ || !captured || *captured < still_->first + kSettling;
  }
  std::string progress_text(size_t needed) const {
    const std::string count = fmt::format("{} of {} positions. ", tour_ ? tour_->samples().size() : 0, needed);
    if (!obstacle_.empty()) return count + "The arm waits: " + obstacle_ + ".";
    if (!reason_.empty()) return count + "Vision does not see the object here: " + reason_ + ".";
    return count + "The arm moves slowly from one posture to the next. Space stops it.";
  }

  bool active_ = false;
  std::optional<std::pair<int64_t, Eigen::Vector3d>> still_;  // since when, by the time of receipt, and where
  std::optional<PostureTour> tour_;
  std::string obstacle_, fault_, reason_;
};

constexpr size_t kLeastPositions = 14, kMostPositions = 50, kFirstEstimate = 6;
constexpr double kMostRms = 0.005, kMostSigma = 0.003;  // m

class PoseStep : public TourStep {
 public:
  explicit PoseStep(const CourseFolder& folder) : done_(CourseFolder::exists(folder.pose())) {}

  const char* name() const override { return "pose"; }
  bool done() const override { return done_; }

  void begin(CourseContext& context, const json& request) override {
    options_ = {.estimate_offset = true};
    if (const auto offset = request.find("offset_m"); offset != request.end() && offset->is_array()) {
      if (offset->size() != 3) throw InputError("offset_m: expected three numbers, in metres");
      for (size_t i = 0; i < 3; ++i) {
        if (!(*offset)[i].is_number() || !(std::abs((*offset)[i].get<double>()) < 10))
          throw InputError("offset_m: expected three numbers, in metres");
        options_.p_HT[static_cast<Eigen::Index>(i)] = (*offset)[i].get<double>();
      }
      options_.estimate_offset = false;
    }
    again(context);
    rig_ = read_camera_files({context.folder.stereo()}, {}).rig;
    start(context);
  }

  void again(CourseContext& context) override {
    for (const std::string& file : {context.folder.pose(), context.folder.check()}) CourseFolder::remove(file);
    context.folder.write_vision();
    done_ = false;
    active_ = false;
    estimate_.reset();
    summary_.clear();
    solved_ = 0;
  }

  void target(const target_t& target, CourseContext& context) override {
    if (active_ && target.status != target_t::STATUS_TRACKED)
      measure(target, target_t::STATUS_UNCALIBRATED, rig_, context);
  }

  std::string text() const override {
    if (done_) return "The camera pose is known." + (summary_.empty() ? "" : " " + summary_);
    if (!fault_.empty()) return "That did not work: " + fault_ + ".";
    if (!active_)
      return "Fix the object to the robot's hand so that both cameras see it, clear the robot's surroundings, and "
             "begin: the "
             "arm then moves by itself, slowly, through postures near this one.";
    return progress_text(kLeastPositions);
  }

  json details() const override {
    json hands = json::array();
    if (tour_) {
      for (const HandEyeSample& sample : tour_->samples()) hands.push_back(list(sample.X_WH.translation()));
    }
    return {{"positions", hands}, {"needed", kLeastPositions}};
  }

 private:
  uint64_t seed() const override { return 41; }
  bool wanted(const Eigen::Isometry3d& X_WH) const override {
    return !estimate_ || in_view(rig_, estimate_->X_WL.inverse() * (X_WH * estimate_->p_HT));
  }

  void progress(CourseContext& context) override {
    const size_t count = tour_->samples().size();
    if (count == solved_ || count < kFirstEstimate) return;
    solved_ = count;
    try {
      estimate_ = solve_hand_eye(tour_->samples(), options_);
    } catch (const std::runtime_error& fault) {
      if (count >= kMostPositions) give_up(fault.what(), context);
      return;
    }
    if (count < kLeastPositions) return;
    const double sigma = std::sqrt(estimate_->covariance.diagonal().tail<3>().maxCoeff());
    if (estimate_->rms_m > kMostRms || sigma > kMostSigma) {
      if (count >= kMostPositions)
        give_up(estimate_->rms_m > kMostRms
                    ? fmt::format("the positions fit to {:.1f} mm only; is the object fixed to the hand",
                                  1e3 * estimate_->rms_m)
                    : fmt::format("after {} positions, the cameras' position is known to {:.1f} mm only; begin from a "
                                  "posture around which both cameras see more of what the arm can reach",
                                  count, 1e3 * sigma),
                context);
      return;
    }
    write_text_file(context.folder.pose(), hand_eye_text(*estimate_, options_));
    CourseFolder::Settings settings = context.folder.settings();
    settings.p_HT = estimate_->p_HT;
    context.folder.change(settings);
    context.folder.write_vision();
    summary_ = fmt::format("{} positions fit to {:.1f} mm.", count, 1e3 * estimate_->rms_m);
    done_ = true;
    finish(context);
  }

  void give_up(const std::string& why, CourseContext& context) {
    fault_ = why;
    finish(context);
  }

  bool done_ = false;
  HandEyeOptions options_;
  StereoRig rig_;
  std::optional<HandEye> estimate_;
  std::string summary_;
  size_t solved_ = 0;
};

constexpr size_t kCheckedPositions = 8;
constexpr double kGood = 0.004, kWorst = 0.010;  // m: median and maximum of a check that passes

class CheckStep : public TourStep {
 public:
  explicit CheckStep(const CourseFolder& folder) {
    if (!CourseFolder::exists(folder.check())) return;
    const json file = json::parse(read_text_file(folder.check()), nullptr, false);
    if (!file.is_object() || !file.contains("points") || !file.contains("text")) return;
    points_ = file["points"];
    result_ = file["text"];
    done_ = true;
  }

  const char* name() const override { return "check"; }
  bool done() const override { return done_; }

  void begin(CourseContext& context, const json&) override {
    again(context);
    const RigConfig cameras = load_rig(Config::load(context.folder.vision()).section("cameras"));
    rig_ = cameras.rig;
    p_HT_ = context.folder.settings().p_HT.value_or(Eigen::Vector3d::Zero());
    start(context);
  }

  void again(CourseContext& context) override {
    CourseFolder::remove(context.folder.check());
    done_ = active_ = false;
    result_.clear();
    points_ = json::array();
  }

  void target(const target_t& target, CourseContext& context) override {
    vision_knows_ = target.status != target_t::STATUS_UNCALIBRATED;
    if (active_ && vision_knows_) measure(target, target_t::STATUS_TRACKED, rig_, context);
  }

  std::string text() const override {
    if (!result_.empty()) return result_;
    if (!fault_.empty()) return "That did not work: " + fault_ + ".";
    if (!active_)
      return "The object is still in the hand: begin, and compare where the arm has it with where the cameras see it, "
             "at other positions.";
    return vision_knows_ ? progress_text(kCheckedPositions) : "Waiting for vision to start with the camera pose.";
  }

  json details() const override { return {{"points", points_}, {"needed", kCheckedPositions}}; }

 private:
  uint64_t seed() const override { return 43; }
  bool wanted(const Eigen::Isometry3d& X_WH) const override {
    return in_view(rig_, rig_.X_WL.inverse() * (X_WH * p_HT_));
  }

  void progress(CourseContext& context) override {
    const auto& samples = tour_->samples();
    if (samples.size() == points_.size()) return;
    points_ = json::array();
    std::vector<double> distances;
    for (const HandEyeSample& sample : samples) {
      const Eigen::Vector3d held = sample.X_WH * p_HT_, seen = sample.p_LT;  // both in W
      distances.push_back((held - seen).norm());
      points_.push_back(
          {{"held_m", list(held)}, {"seen_m", list(seen)}, {"mm", std::round(1e4 * distances.back()) / 10}});
    }
    if (samples.size() < kCheckedPositions) return;
    std::ranges::sort(distances);
    const double median = distances[distances.size() / 2], worst = distances.back();
    done_ = median <= kGood && worst <= kWorst;
    result_ = fmt::format("Seen where the arm has it: {:.1f} mm apart (median), {:.1f} mm at most, over {} positions.",
                          1e3 * median, 1e3 * worst, distances.size());
    if (!done_)
      result_ += fmt::format(
          " That is too much: below {:.0f} and {:.0f} mm were expected. Has a camera been moved, or does the object "
          "turn in "
          "the hand? Then do the step before again. Where most positions fit and few are far off, vision saw something "
          "else "
          "with the object's colours: take that away, and begin again.",
          1e3 * kGood, 1e3 * kWorst);
    else
      write_json_file(context.folder.check(), {{"points", points_}, {"text", result_}});
    finish(context);
  }

  bool done_ = false, vision_knows_ = true;
  StereoRig rig_;
  Eigen::Vector3d p_HT_ = Eigen::Vector3d::Zero();
  json points_ = json::array();
  std::string result_;
};

}  // namespace

std::unique_ptr<CourseStep> pose_step(const CourseFolder& folder) {
  return std::make_unique<PoseStep>(folder);
}

std::unique_ptr<CourseStep> check_step(const CourseFolder& folder) {
  return std::make_unique<CheckStep>(folder);
}

}  // namespace multireach
