// The set-up course without cameras and robot: its order, its files, and how it moves the arm.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <opencv2/imgcodecs.hpp>

#include "runtime/channels.hpp"
#include "runtime/files.hpp"
#include "runtime/joint_fields.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/page/course.hpp"
#include "tools/page/safe_postures.hpp"

namespace multireach {
namespace {

using json = nlohmann::json;

RobotConfig hoap2() {
  return RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml");
}

bridge_state_t bridge_state(int8_t state, double rate = 1) {
  bridge_state_t message{};
  message.state = state;
  message.setpoint_rate = rate;
  return message;
}

/// An arm that follows the set-points of an ArmMotion at once.
class Follower {
 public:
  explicit Follower(const Chain& chain) : chain_(chain), motion_(chain, 7) {}

  void stand_at(const JointVector& theta) { motion_.robot(theta, JointVector::Zero(theta.size()), false); }
  /// One period; returns the set-point, if one was sent.
  std::optional<joint_setpoint_t> step() {
    now_us_ += ArmMotion::kPeriod;
    Outbox out;
    motion_.tick(now_us_, out);
    if (out.empty()) return std::nullopt;
    const auto setpoint = *decode<joint_setpoint_t>(out.at(0).bytes);
    motion_.robot(*from_fields(chain_, setpoint.joint_name, setpoint.joint_position),
                  *from_fields(chain_, setpoint.joint_name, setpoint.joint_velocity), false);
    return setpoint;
  }
  ArmMotion& motion() { return motion_; }

 private:
  Chain chain_;
  ArmMotion motion_;
  int64_t now_us_ = 1000000;
};

TEST(ArmMotion, GoesStraightAndSlowlyAndArrives) {
  const Chain chain = hoap2().chain;
  Follower arm(chain);
  const JointVector from = JointVector::Constant(4, -0.3), to = (JointVector(4) << 0.2, -0.5, 0.1, -0.9).finished();
  arm.motion().go_to(to);
  EXPECT_FALSE(arm.motion().moving()) << "where the robot is, is unknown";
  arm.stand_at(from);
  arm.motion().bridge(bridge_state(bridge_state_t::ARMED));
  arm.motion().go_to(to);
  std::optional<joint_setpoint_t> last;
  int periods = 0;
  for (; !arm.motion().arrived(); ++periods) {
    ASSERT_LT(periods, 1000);
    const auto setpoint = arm.step();
    ASSERT_TRUE(setpoint);
    EXPECT_EQ(setpoint->run, 7);
    arm.motion().bridge(bridge_state(bridge_state_t::RUNNING));
    for (size_t i = 0; i < 4; ++i) {
      const double limit =
          std::min(ArmMotion::kFastest, ArmMotion::kShareOfLimit * chain.velocity()[static_cast<int>(i)]);
      EXPECT_LE(std::abs(setpoint->joint_velocity[i]), limit * (1 + 1e-9));
      if (last) {  // the velocity is the derivative of the position
        const double mean = (setpoint->joint_position[i] - last->joint_position[i]) / (1e-6 * ArmMotion::kPeriod);
        EXPECT_NEAR(mean, 0.5 * (setpoint->joint_velocity[i] + last->joint_velocity[i]), 0.02);
      }
    }
    last = setpoint;
  }
  EXPECT_LT((*arm.motion().theta() - to).norm(), 1e-9);
  EXPECT_GT(periods, 20);
}

TEST(ArmMotion, WaitsWhilePausedAndBeginsAgainWhereTheRobotIsWhenItIsEnabled) {
  const Chain chain = hoap2().chain;
  Follower arm(chain);
  arm.stand_at(JointVector::Constant(4, -0.3));
  arm.motion().bridge(bridge_state(bridge_state_t::RUNNING));
  arm.motion().go_to(JointVector::Constant(4, -0.8));
  for (int k = 0; k < 10; ++k) arm.step();
  const JointVector before = *arm.motion().theta();
  arm.motion().bridge(bridge_state(bridge_state_t::RUNNING, 0));
  for (int k = 0; k < 10; ++k) arm.step();
  EXPECT_LT((*arm.motion().theta() - before).norm(), 1e-9);
  EXPECT_NE(arm.motion().obstacle().find("paused"), std::string::npos);
  arm.motion().bridge(bridge_state(bridge_state_t::IDLE));
  EXPECT_FALSE(arm.step()) << "no set-points for a robot that is disabled";
  EXPECT_NE(arm.motion().obstacle().find("enable it"), std::string::npos);
  const JointVector moved = JointVector::Constant(4, -0.5);  // by hand
  arm.stand_at(moved);
  arm.step();
  arm.motion().bridge(bridge_state(bridge_state_t::ARMED));
  const auto first = arm.step();
  ASSERT_TRUE(first);
  for (const double position : first->joint_position) EXPECT_NEAR(position, -0.5, 0.01);
}

TEST(SafePostures, StayNearAndInsideTheLimitsAndAreWanted) {
  const RobotConfig robot = hoap2();
  const JointVector first = (JointVector(4) << 0.2, -0.3, -0.2, -0.9).finished();
  SafePostures postures(robot, first, 5);
  JointVector at = first;
  for (int k = 0; k < 200; ++k) {
    const auto next = postures.next(at, [](const Eigen::Isometry3d& X_WH) { return X_WH.translation().z() > 0; });
    ASSERT_TRUE(next) << k;
    EXPECT_EQ(robot.chain.limit_excess(*next), 0);
    EXPECT_LE((*next - first).cwiseAbs().maxCoeff(), SafePostures::kWidth);
    EXPECT_GT(robot.chain.position(*next).z(), 0);
    at = *next;
  }
  EXPECT_FALSE(postures.next(at, [](const Eigen::Isometry3d&) { return false; }));
}

class CourseTest : public ::testing::Test {
 protected:
  Touch::Answer ask(Course& course, const std::string& what, const std::string& step, json more = json::object()) {
    more.update({{"request", "course"}, {"do", what}, {"step", step}});
    return course.handle(more, 1000000, out_);
  }
  static std::string open_step(const Course& course) { return course.status()["open"]; }

  const testing::TemporaryFolder parent_;
  const std::string folder_ = parent_ / "course";
  Touch touch_{3};
  Outbox out_;
};

TEST_F(CourseTest, StepsComeInTheirOrderAndFilesOfAnEarlierDayAreTakenUp) {
  {
    Course course(hoap2(), folder_, false, 3, touch_);
    EXPECT_EQ(open_step(course), "cameras");
    EXPECT_FALSE(ask(course, "begin", "board").accepted) << "no cameras yet";
    EXPECT_FALSE(ask(course, "begin", "nonsense").accepted);
    EXPECT_FALSE(ask(course, "dance", "cameras").accepted);
    EXPECT_TRUE(ask(course, "begin", "cameras").accepted);
  }
  const std::string cameras =
      "left: {width_px: 320, height_px: 240, fx_px: 300, fy_px: 300, cx_px: 160, cy_px: 120}\n"
      "right: {width_px: 320, height_px: 240, fx_px: 300, fy_px: 300, cx_px: 160, cy_px: 120}\n"
      "left_to_right: {translation_m: [-0.06, 0, 0]}\n";
  write_text_file(folder_ + "/stereo.yaml", cameras);
  Course course(hoap2(), folder_, false, 3, touch_);
  EXPECT_EQ(open_step(course), "object");
  EXPECT_FALSE(ask(course, "begin", "pose").accepted);
  EXPECT_TRUE(ask(course, "begin", "object", {{"radius_m", 0.02}}).accepted);
  EXPECT_FALSE(ask(course, "begin", "object", {{"radius_m", -1}}).accepted);
  EXPECT_FALSE(ask(course, "act", "object", {{"u", 0.5}, {"v", 0.5}}).accepted) << "there are no images";
  EXPECT_EQ(Course(hoap2(), folder_, false, 3, touch_).status()["radius_m"], 0.02);
  EXPECT_TRUE(ask(course, "show", "board").accepted);
  EXPECT_TRUE(ask(course, "again", "board").accepted);
  EXPECT_EQ(open_step(course), "cameras");
  EXPECT_FALSE(CourseFolder::exists(folder_ + "/stereo.yaml"));
}

TEST_F(CourseTest, UntilItIsCompleteTheControllerFollowsNothing) {
  Course course(hoap2(), folder_, false, 3, touch_);
  course.tick(1000000, true, out_);
  const auto choice = std::ranges::find(out_, channel::kTargetChoice, &OutMessage::channel);
  ASSERT_NE(choice, out_.end());
  EXPECT_EQ(decode<target_choice_t>(choice->bytes)->kind, target_choice_t::NONE);
}

TEST_F(CourseTest, SaysFromItsFirstStepWhichRobotAnswersAndThatNoRealOneWasTried) {
  Course course(hoap2(), folder_, false, 3, touch_);
  const auto says = [&](const char* words) {
    const json status = course.status();
    EXPECT_EQ(status["current"], "cameras");
    const std::string text = status["robot"];
    EXPECT_NE(text.find("never on a real robot"), std::string::npos) << text;
    return text.find(words) != std::string::npos;
  };
  const auto hear = [&](bool simulated, int64_t now_us) {
    const RobotConfig robot = hoap2();
    robot_state_t state{};
    state.simulated = simulated;
    state.num_joints = static_cast<int32_t>(robot.chain.size());
    state.joint_name = joint_names(robot.chain);
    state.joint_position.assign(state.joint_name.size(), 0.0);
    state.joint_velocity = state.joint_effort = state.joint_position;
    course.receive(channel::kRobotState, *encode(state), now_us, out_);
  };
  course.tick(1000000, true, out_);
  EXPECT_TRUE(says("No robot is heard"));
  hear(true, 1100000);
  EXPECT_TRUE(says("The robot is simulated"));
  hear(false, 1200000);
  EXPECT_TRUE(says("This is a real robot"));
  course.tick(3200001, true, out_);
  EXPECT_TRUE(says("No robot is heard"));
  EXPECT_NE(Course(hoap2(), folder_, true, 3, touch_).status()["robot"].dump().find("Practice: simulated robot"),
            std::string::npos);
}

TEST_F(CourseTest, PracticeScenesAreShownOnlyInAPractice) {
  for (const bool practice : {false, true}) {
    out_.clear();
    Course course(hoap2(), folder_, practice, 3, touch_);
    ASSERT_TRUE(ask(course, "begin", "cameras").accepted);
    EXPECT_EQ(std::ranges::count(out_, channel::kPracticeScene, &OutMessage::channel), practice ? 1 : 0);
  }
}

TEST(CaptureTime, IsTheCamerasClockHoweverLongMessagesTook) {
  constexpr int64_t kMs = 1000, kWall = 1790000000000000;
  CaptureTime time;
  EXPECT_FALSE(time.of(kWall));
  time.observe(kWall, 5 * kMs);  // of a receiver whose clock begins at 0; 5 ms on the way
  for (int k = 1; k < 300; ++k) time.observe(kWall + k * 66 * kMs, k * 66 * kMs + k % 50 * 100 * kMs + 20 * kMs);
  EXPECT_EQ(*time.of(kWall + 300 * 66 * kMs), 300 * 66 * kMs + 5 * kMs);
  // The cameras' clock is set back by a minute.
  time.observe(kWall - 60000 * kMs, 20000 * kMs);
  EXPECT_EQ(*time.of(kWall - 60000 * kMs), 20000 * kMs);
}

/// An arm that holds the object, and cameras whose targets arrive ever later, as under load.
class LaggingCourse : public CourseTest {
 protected:
  static constexpr int64_t kWall = 1790000000000000, kPair = 66000;  // us
  static Eigen::Isometry3d X_WL() {
    return Eigen::Translation3d(-0.15, -0.07, 0.45) * (Eigen::AngleAxisd(-1.570796, Eigen::Vector3d::UnitZ()) *
                                                       Eigen::AngleAxisd(-2.54818, Eigen::Vector3d::UnitX()));
  }

  LaggingCourse() {
    std::filesystem::create_directories(folder_);
    write_text_file(
        folder_ + "/stereo.yaml",
        "cameras:\n  left: {width_px: 320, height_px: 240, fx_px: 300, fy_px: 300, cx_px: 160, cy_px: 120}\n"
        "  right: {width_px: 320, height_px: 240, fx_px: 300, fy_px: 300, cx_px: 160, cy_px: 120}\n"
        "  left_to_right: {translation_m: [-0.06, 0, 0]}\n");
    write_text_file(folder_ + "/ball.colour.yaml", "references: [{rgb: [220, 40, 110]}]\n");
  }

  /// 20 ms of the page's time: the robot's state, by its own clock from 0, and targets that are due by now.
  void step(Course& course) {
    now_us_ += 20000;
    out_.clear();
    course.tick(now_us_, true, out_);
    for (const OutMessage& message : out_) {
      if (message.channel != channel::kJointSetpoint) continue;
      const auto setpoint = *decode<joint_setpoint_t>(message.bytes);
      state_.joint_position = setpoint.joint_position;
      state_.joint_velocity = setpoint.joint_velocity;
    }
    state_.utime = now_us_ - kWall;
    receive(course, channel::kRobotState, state_);
    receive(course, channel::kBridgeState, bridge_state(bridge_state_t::RUNNING));
    if (now_us_ - captured_us_ >= kPair) {
      captured_us_ = now_us_;
      const auto theta = *from_fields(robot_.chain, state_.joint_name, state_.joint_position);
      const Eigen::Vector3d p = X_WL().inverse() * (robot_.chain.pose(theta) * Eigen::Vector3d(0.01, 0.004, -0.006));
      target_t target{};
      target.name = "ball";
      target.status = target_t::STATUS_UNCALIBRATED;
      target.utime = now_us_;
      Eigen::Map<Eigen::Vector3d>(target.position_m) = p;
      Eigen::Map<Eigen::Matrix3d>(&target.covariance_m2[0][0]) = 1e-7 * Eigen::Matrix3d::Identity();
      underway_.push_back(target);
    }
    const int64_t lag = std::min<int64_t>(20000 + (now_us_ - kWall) / 5, 4000000);
    while (!underway_.empty() && underway_.front().utime + lag <= now_us_) {
      receive(course, channel::kTarget, underway_.front());
      underway_.pop_front();
    }
  }
  template <class Message>
  void receive(Course& course, std::string_view channel, const Message& message) {
    course.receive(channel, *encode(message), now_us_, out_);
  }

  RobotConfig robot_ = hoap2();
  robot_state_t state_{};
  std::deque<target_t> underway_;
  int64_t now_us_ = kWall, captured_us_ = 0;
};

TEST_F(LaggingCourse, ImagesOfThePostureBeforeDoNotCount) {
  state_.simulated = true;
  state_.num_joints = robot_.chain.size();
  state_.joint_name = joint_names(robot_.chain);
  state_.joint_position = {0.2, -0.3, -0.2, -0.9};
  state_.joint_velocity.assign(4, 0);
  state_.joint_effort.assign(4, 0);
  Course course(robot_, folder_, false, 3, touch_);
  ASSERT_EQ(open_step(course), "pose");
  step(course);
  const auto begun = course.handle({{"request", "course"}, {"do", "begin"}, {"step", "pose"}}, now_us_, out_);
  ASSERT_TRUE(begun.accepted) << begun.text;
  for (int k = 0; k < 50 * 600 && open_step(course) == "pose" && course.status()["begun"]; ++k) step(course);
  const std::string text = course.status()["steps"][3]["text"];
  const size_t at = text.find("fit to ");
  ASSERT_NE(at, std::string::npos) << text;
  EXPECT_LT(std::stod(text.substr(at + 7)), 2) << "mm, within which a hand counts as standing still: " << text;
}

TEST(JpegUrl, HoldsTheImage) {
  const std::string head = "data:image/jpeg;base64,";
  for (int width = 20; width < 26; ++width) {  // all lengths of the last group
    const std::string url = jpeg_url(cv::Mat(10, width, CV_8UC3, cv::Scalar(10, 200, 90)));
    ASSERT_TRUE(url.starts_with(head));
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::vector<uint8_t> bytes;
    uint32_t bits = 0;
    int count = 0;
    for (const char c : url.substr(head.size())) {
      if (c == '=') break;
      bits = bits << 6 | static_cast<uint32_t>(digits.find(c));
      if ((count += 6) < 8) continue;
      bytes.push_back(static_cast<uint8_t>(bits >> (count -= 8)));
    }
    const cv::Mat image = cv::imdecode(bytes, cv::IMREAD_COLOR);
    ASSERT_EQ(image.size(), cv::Size(width, 10));
    EXPECT_NEAR(image.at<cv::Vec3b>(5, 5)[1], 200, 4);
  }
}

}  // namespace
}  // namespace multireach
