#include "tools/log/latency.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <multireach/joint_command_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/target_t.hpp>
#include <optional>
#include <utility>

#include "runtime/channels.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message_walk.hpp"
#include "runtime/node.hpp"
#include "tools/log/quantile.hpp"

namespace multireach {
namespace {

/// A message that another one names can only be near it in time: sequence numbers restart with each run.
constexpr int64_t kNear = 10000000;  // us

/// Channels on which drivers command robots (robot_bridge/drivers).
constexpr std::array kWires{"IIWA_COMMAND", "PANDA_COMMAND"};
/// Later than this after a JOINT_COMMAND, a driver decelerates the arm by itself; a longer period is a pause.
constexpr int64_t kFollowing = 20000;  // us

/// A message by its two times, microseconds.
struct Timed {
  int64_t arrival = 0, utime = 0;
};

/// Messages by the number under which others name them.
class Named {
 public:
  void add(int64_t number, Timed message) { messages_.emplace(number, message); }
  /// The message of this number that arrived nearest to a time; nothing when none is near.
  std::optional<Timed> nearest(int64_t number, int64_t arrival) const {
    std::optional<Timed> best;
    const auto [begin, end] = messages_.equal_range(number);
    for (auto at = begin; at != end; ++at) {
      const int64_t distance = std::abs(at->second.arrival - arrival);
      if (distance <= kNear && (!best || distance < std::abs(best->arrival - arrival))) best = at->second;
    }
    return best;
  }

 private:
  std::multimap<int64_t, Timed> messages_;
};

/// The delays of one stage, milliseconds.
struct Delays {
  std::vector<double> arrival, message;

  void add(const Timed& from, const Timed& to) {
    arrival.push_back(static_cast<double>(to.arrival - from.arrival) * 1e-3);
    message.push_back(static_cast<double>(to.utime - from.utime) * 1e-3);
  }
};

DelayStatistics statistics_of(const std::vector<double>& delays_ms) {
  if (delays_ms.empty()) return {};
  return {.count = static_cast<int64_t>(delays_ms.size()),
          .p50_ms = quantile(delays_ms, 0.5),
          .p95_ms = quantile(delays_ms, 0.95),
          .p99_ms = quantile(delays_ms, 0.99),
          .max_ms = quantile(delays_ms, 1)};
}

struct Setpoint {
  Timed time;
  int64_t sequence = 0, run = 0, target_sequence = -1;
};

/// All messages of the line from the cameras to the robot.
struct Messages {
  Named images, targets, first_commands;  // by the pair's time, the sequence number, the set-point that they name
  std::vector<Setpoint> setpoints;
  struct WireDelays {
    std::vector<double> period_ms, delay_ms;
    int64_t previous = 0;
  };
  std::map<std::string, WireDelays> wires;
  int64_t number_of_targets = 0;

  explicit Messages(const std::string& path) {
    LogReader log(path);
    while (const auto event = log.next()) {
      if (plausible_utime(event->utime)) add(*event);
    }
  }

 private:
  void add(const LogEvent& event) {
    if (event.channel == channel::kStereoImages) {
      if (event.data.size() < 16) return;
      const auto utime = big_endian<int64_t>(event.data.subspan(8));  // first field of images_t
      if (plausible_utime(utime)) images.add(utime, {event.utime, utime});
    } else if (event.channel == channel::kTarget) {
      const auto target = decode<target_t>(event.data);
      if (!target || !plausible_utime(target->utime)) return;
      ++number_of_targets;
      targets.add(target->sequence, {event.utime, target->utime});
    } else if (event.channel == channel::kJointSetpoint) {
      const auto setpoint = decode<joint_setpoint_t>(event.data);
      if (!setpoint || !plausible_utime(setpoint->utime)) return;
      setpoints.push_back(
          {{event.utime, setpoint->utime}, setpoint->sequence, setpoint->run, setpoint->target_sequence});
    } else if (event.channel == channel::kJointCommand) {
      const auto command = decode<joint_command_t>(event.data);
      if (!command || !plausible_utime(command->utime)) return;
      newest_command_ = event.utime;
      int64_t& newest = newest_setpoint_.try_emplace(command->run, -1).first->second;
      if (command->setpoint_sequence == newest) return;
      newest = command->setpoint_sequence;
      first_commands.add(newest, {event.utime, command->utime});
    } else if (std::ranges::find(kWires, event.channel) != kWires.end()) {
      WireDelays& wire = wires[std::string(event.channel)];
      const int64_t period = event.utime - std::exchange(wire.previous, event.utime);
      const int64_t delay = event.utime - newest_command_;
      if (delay < 0 || delay > kFollowing || period > kFollowing) return;
      wire.period_ms.push_back(static_cast<double>(period) * 1e-3);
      wire.delay_ms.push_back(static_cast<double>(delay) * 1e-3);
    }
  }

  int64_t newest_command_ = 0;  // when it arrived

  std::map<int64_t, int64_t> newest_setpoint_;  // by the bridge's run
};

}  // namespace

LatencyReport latency_of(const std::string& log_path) {
  const Messages messages(log_path);
  LatencyReport report;
  report.targets = messages.number_of_targets;
  Delays capture, vision, controller, bridge, all;
  std::map<int64_t, int64_t> newest_target;  // by the controller's run
  for (const Setpoint& setpoint : messages.setpoints) {
    int64_t& newest = newest_target.try_emplace(setpoint.run, -1).first->second;
    if (setpoint.target_sequence < 0 || setpoint.target_sequence == newest) continue;
    newest = setpoint.target_sequence;
    const auto target = messages.targets.nearest(setpoint.target_sequence, setpoint.time.arrival);
    if (!target) continue;
    ++report.taken_up;
    controller.add(*target, setpoint.time);
    const auto images = messages.images.nearest(target->utime, target->arrival);
    if (images) {
      vision.add(*images, *target);
      // The capture has no time of arrival: comparable where the cameras' clock is the logger's, not for a session that
      // is played again.
      if (std::abs(images->arrival - images->utime) <= kNear) capture.add({images->utime, images->utime}, *images);
    }
    const auto command = messages.first_commands.nearest(setpoint.sequence, setpoint.time.arrival);
    if (!command) {
      ++report.without_command;
      continue;
    }
    bridge.add(setpoint.time, *command);
    if (images) all.add(*images, *command);
  }
  capture.message.clear();
  const auto add = [&](const std::string& from, std::string_view to, const Delays& delays) {
    report.stages.push_back({from, std::string(to), statistics_of(delays.arrival), statistics_of(delays.message)});
  };
  add("capture", channel::kStereoImages, capture);
  add(std::string(channel::kStereoImages), channel::kTarget, vision);
  add(std::string(channel::kTarget), channel::kJointSetpoint, controller);
  add(std::string(channel::kJointSetpoint), channel::kJointCommand, bridge);
  add(std::string(channel::kStereoImages), channel::kJointCommand, all);
  for (const auto& [channel, wire] : messages.wires)
    report.wires.push_back({channel, statistics_of(wire.period_ms), statistics_of(wire.delay_ms)});
  return report;
}

nlohmann::json LatencyReport::json() const {
  const auto numbers = [](const DelayStatistics& delays) -> nlohmann::json {
    if (delays.count == 0) return nullptr;
    return {{"count", delays.count},
            {"p50", delays.p50_ms},
            {"p95", delays.p95_ms},
            {"p99", delays.p99_ms},
            {"max", delays.max_ms}};
  };
  nlohmann::json list = nlohmann::json::array();
  for (const Stage& stage : stages) {
    list.push_back({{"from", stage.from},
                    {"to", stage.to},
                    {"by_arrival_ms", numbers(stage.by_arrival)},
                    {"by_message_ms", numbers(stage.by_message)}});
  }
  nlohmann::json wire_list = nlohmann::json::array();
  for (const Wire& wire : wires) {
    wire_list.push_back(
        {{"channel", wire.channel}, {"period_ms", numbers(wire.period)}, {"delay_ms", numbers(wire.delay)}});
  }
  return {{"targets", targets},
          {"taken_up", taken_up},
          {"without_command", without_command},
          {"stages", list},
          {"wires", wire_list}};
}

std::string LatencyReport::table() const {
  std::string text = fmt::format("{} targets, {} taken up by a tick, {} of them without a command of their own\n",
                                 targets, taken_up, without_command);
  text += fmt::format("{:<33}{:^36}  {:^36}\n{:<33}", "", "by arrival (ms)", "by message time (ms)", "");
  for (int i = 0; i < 2; ++i) text += fmt::format("{:>9}{:>9}{:>9}{:>9}  ", "p50", "p95", "p99", "max");
  text += "\n";
  for (const Stage& stage : stages) {
    text += fmt::format("{:<33}", stage.from + " -> " + stage.to);
    for (const DelayStatistics& delays : {stage.by_arrival, stage.by_message}) {
      for (const double value : {delays.p50_ms, delays.p95_ms, delays.p99_ms, delays.max_ms}) {
        text += delays.count > 0 ? fmt::format("{:>9.2f}", value) : fmt::format("{:>9}", "-");
      }
      text += "  ";
    }
    text += "\n";
  }
  for (const Wire& wire : wires) {
    if (wire.period.count == 0) continue;
    text += fmt::format(
        "{}: period p50 {:.2f}, p99 {:.2f}, max {:.2f} ms; after JOINT_COMMAND p50 {:.2f}, p99 {:.2f}, "
        "max {:.2f} ms\n",
        wire.channel, wire.period.p50_ms, wire.period.p99_ms, wire.period.max_ms, wire.delay.p50_ms, wire.delay.p99_ms,
        wire.delay.max_ms);
  }
  return text;
}

}  // namespace multireach
