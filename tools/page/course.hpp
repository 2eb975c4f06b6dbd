#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/page/course_step.hpp"

namespace multireach {

/// The guided set-up: from two cameras to an arm that reaches, step by step. Each step shows what is right or wrong and
/// what to do, keeps its result in the files that the command-line tools write too, and so can be continued another
/// day. Knows time only from its arguments, microseconds.
class Course {
 public:
  /// `practice`: with rendered cameras, to which it shows what a user's hands would. `run`: of the page, for messages.
  Course(const RobotConfig& robot, const std::string& folder, bool practice, int64_t run, Touch& touch);

  static std::vector<std::string_view> inputs();
  /// {"request": "course", "do": "show" | "begin" | "act" | "again" | "leave", "step": …, …}
  Touch::Answer handle(const nlohmann::json& request, int64_t now_us, Outbox& out);
  void receive(std::string_view channel, std::span<const uint8_t> bytes, int64_t now_us, Outbox& out);
  /// `watched`: whether a browser shows the page. The arm moves only while one does.
  void tick(int64_t now_us, bool watched, Outbox& out);
  /// What the page shows.
  nlohmann::json status() const;

 private:
  CourseContext context(int64_t now_us, Outbox& out);
  /// Which robot answers, and on what the course was tried: from the first step on, so that nobody trusts it more.
  std::string robot_text() const;
  /// The first step that is not done.
  size_t first_open() const;
  CourseStep& current() { return *steps_[current_]; }

  RobotConfig robot_;
  CourseFolder folder_;
  bool practice_;
  Touch& touch_;
  ArmMotion arm_;
  CaptureTime capture_time_;
  std::vector<std::unique_ptr<CourseStep>> steps_;
  size_t current_ = 0;
  bool begun_ = false;  // the current step is being done
  bool chosen_ = false;
  int64_t watched_us_ = 0;
  int64_t now_us_ = 0;                     // of the last tick
  std::optional<int64_t> robot_heard_us_;  // when the last ROBOT_STATE came
  bool simulated_ = false;                 // whether it was of a simulated robot
};

}  // namespace multireach
