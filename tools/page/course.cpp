#include "tools/page/course.hpp"

#include <algorithm>
#include <multireach/bridge_state_t.hpp>
#include <multireach/robot_state_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/files.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach {

using nlohmann::json;

Course::Course(const RobotConfig& robot, const std::string& folder, bool practice, int64_t run, Touch& touch)
    : robot_(robot), folder_(folder), practice_(practice), touch_(touch), arm_(robot.chain, run) {
  steps_.push_back(cameras_step());
  steps_.push_back(board_step(folder_));
  steps_.push_back(object_step(folder_));
  steps_.push_back(pose_step(folder_));
  steps_.push_back(check_step(folder_));
  steps_.push_back(reach_step());
  current_ = first_open();
}

std::vector<std::string_view> Course::inputs() {
  return {channel::kTargetTruth};
}

CourseContext Course::context(int64_t now_us, Outbox& out) {
  return {.folder = folder_,
          .robot = robot_,
          .arm = arm_,
          .touch = touch_,
          .capture_time = capture_time_,
          .practice = practice_,
          .now_us = now_us,
          .out = &out};
}

/// Cameras that were calibrated were found before.
size_t Course::first_open() const {
  for (size_t at = 1; at < steps_.size(); ++at) {
    if (!steps_[at]->done()) return at == 1 && !steps_[0]->done() ? 0 : at;
  }
  return steps_.size() - 1;
}

Touch::Answer Course::handle(const json& request, int64_t now_us, Outbox& out) {
  const auto word = [&](const char* key) {
    const auto found = request.find(key);
    return found != request.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  const std::string what = word("do"), name = word("step");
  const auto found = std::ranges::find_if(steps_, [&](const auto& step) { return step->name() == name; });
  if (found == steps_.end()) return {false, "'" + name + "' is no step of the course"};
  const auto at = static_cast<size_t>(found - steps_.begin());
  CourseContext shared = context(now_us, out);
  try {
    if (what == "begin" || what == "show") {
      if (at > first_open()) return {false, std::string("first comes the step '") + steps_[first_open()]->name() + "'"};
      if (at != current_ || what == "show") current().leave(shared);
      current_ = at;
      begun_ = false;
      if (what == "show") return {true, "shown"};
      current().begin(shared, request);
      begun_ = true;
      return {true, "begun"};
    }
    if (at != current_) return {false, "the step '" + name + "' is not begun"};
    if (what == "act") {
      current().act(shared, request);
      return {true, "taken"};
    }
    if (what == "leave") {
      current().leave(shared);
      begun_ = false;
      return {true, "left"};
    }
    if (what == "again") {
      current().leave(shared);
      current().again(shared);
      // Poses depend on the cameras, checks on the poses.
      for (size_t later = at + 1; later < steps_.size(); ++later) {
        if (name != "object" && steps_[later]->name() != std::string_view("object")) steps_[later]->again(shared);
      }
      begun_ = false;
      return {true, "the result is removed"};
    }
  } catch (const std::exception& fault) {
    return {false, fault.what()};
  }
  return {false, "'" + what + "' is nothing to do; expected show, begin, act, leave or again"};
}

void Course::receive(std::string_view channel, std::span<const uint8_t> bytes, int64_t now_us, Outbox& out) {
  CourseContext shared = context(now_us, out);
  if (channel == channel::kStereoImages) {
    auto images = decode<images_t>(bytes);
    if (!images) return;
    capture_time_.observe(images->utime, now_us);
    const auto pair = std::make_shared<const images_t>(std::move(*images));
    current().images(pair, shared);
  } else if (channel == channel::kTarget) {
    const auto target = decode<target_t>(bytes);
    if (!target || target->name == Touch::kTargetName) return;
    capture_time_.observe(target->utime, now_us);
    current().target(*target, shared);
  } else if (channel == channel::kTargetTruth) {
    if (const auto truth = decode<target_t>(bytes)) current().truth(*truth, shared);
  } else if (channel == channel::kBridgeState) {
    if (const auto state = decode<bridge_state_t>(bytes)) arm_.bridge(*state);
  } else if (channel == channel::kRobotState) {
    const auto state = decode<robot_state_t>(bytes);
    const auto theta = state ? from_fields(robot_.chain, state->joint_name, state->joint_position) : std::nullopt;
    const auto velocity = state ? from_fields(robot_.chain, state->joint_name, state->joint_velocity) : std::nullopt;
    if (!theta || !velocity || !theta->allFinite() || !velocity->allFinite()) return;
    robot_heard_us_ = now_us;
    simulated_ = state->simulated;
    arm_.robot(*theta, *velocity, state->simulated);
    current().robot(*theta, state->utime, shared);
  }
}

void Course::tick(int64_t now_us, bool watched, Outbox& out) {
  constexpr int64_t kUnwatched = 10000000;  // us; a page that lags reconnects
  CourseContext shared = context(now_us, out);
  now_us_ = now_us;
  if (watched) watched_us_ = now_us;
  if (begun_ && now_us - watched_us_ > kUnwatched) {
    current().leave(shared);
    begun_ = false;
  }
  // Until it is complete, the controller must not reach for what the robot's hand holds.
  if (!chosen_ && first_open() + 1 < steps_.size())
    touch_.choose(target_choice_t::NONE, "the set-up course", now_us, out);
  chosen_ = true;
  try {
    current().tick(shared);
    if (begun_ && current().ended() && !current().done()) begun_ = false;
  } catch (const std::exception&) {  // a file that cannot be written; the step says what is missing
    current().leave(shared);
    begun_ = false;
  }
  arm_.tick(now_us, out);
}

std::string Course::robot_text() const {
  constexpr int64_t kSilent = 2000000;  // us
  constexpr const char* kDrivers =
      "The drivers that come with multireach were tested against emulators only, never on a real robot";
  if (practice_)
    return std::string(
               "Practice: simulated robot, rendered cameras. With real ones, nobody has done this course yet. ") +
           kDrivers + ".";
  if (!robot_heard_us_ || now_us_ - *robot_heard_us_ > kSilent)
    return std::string("No robot is heard; the steps from 'Camera pose' on need one. ") + kDrivers + ".";
  if (simulated_) return std::string("The robot is simulated. ") + kDrivers + ".";
  return std::string("This is a real robot. ") + kDrivers + ": keep its emergency stop within reach.";
}

json Course::status() const {
  json steps = json::array();
  for (const auto& step : steps_) {
    const bool done =
        step->done() || (step == steps_[0] && steps_[1]->done());  // cameras that were calibrated were found
    steps.push_back({{"name", step->name()}, {"done", done}, {"text", step->text()}});
  }
  return {{"practice", practice_},
          {"folder", folder_.path()},
          {"robot", robot_text()},
          {"current", steps_[current_]->name()},
          {"begun", begun_},
          {"open", steps_[first_open()]->name()},
          {"steps", steps},
          {"details", steps_[current_]->details()},
          {"square_m", folder_.settings().square_m},
          {"radius_m", folder_.settings().radius_m}};
}

}  // namespace multireach
