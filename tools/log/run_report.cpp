#include "tools/log/run_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <multireach/bridge_state_t.hpp>
#include <multireach/controller_state_t.hpp>
#include <multireach/joint_command_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/node_status_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_choice_t.hpp>
#include <multireach/target_t.hpp>
#include <numeric>
#include <set>
#include <utility>

#include "controller/ik/multi_start.hpp"
#include "controller/node/controller_config.hpp"
#include "robot_bridge/node/bridge_node.hpp"
#include "robot_bridge/stream_check.hpp"
#include "runtime/channels.hpp"
#include "runtime/digest.hpp"
#include "runtime/joint_fields.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message_gate.hpp"
#include "runtime/node.hpp"
#include "tools/log/bridge_halts.hpp"
#include "tools/log/dwells.hpp"
#include "tools/log/flights.hpp"
#include "tools/log/quantile.hpp"
#include "tools/log/sequence_gaps.hpp"
#include "tools/log/speed_window.hpp"

namespace multireach {
namespace {

using nlohmann::json;

constexpr double kMet = 0.03;  // m; largest distance to a thrown target that counts as met: a ball in a hand

/// Share of the speed limit that counts as a violation: over 20 ms, jitter of one period is 5 %, that of a late
/// recorder up to a period of ROBOT_STATE more.
constexpr double kFasterThanTheLimit = 1.5;

/// What a node's NODE_STATUS said, over all its starts.
struct NodeRecord {
  node_status_t newest{};
  NodeCounters before{};  ///< counters of the earlier starts
  RefusalCounts refused_before{};
  int64_t restarts = 0;
  std::vector<double> clock_lead_ms;  ///< the node's clock minus the recorder's, and the delay of the message

  void add(const node_status_t& status, int64_t received_utime) {
    if (plausible_utime(status.utime) && plausible_utime(received_utime))
      clock_lead_ms.push_back(1e-3 * static_cast<double>(status.utime - received_utime));
    // Anybody may run several viewers.
    if (!newest.node.empty() && status.node != "view" && started_after_newest(status)) {
      ++restarts;
      before = total();
      refused_before = refused_by_name();
    }
    newest = status;
  }
  /// A node that was restarted twice within a second sends the same uptime again, but says that it started later. Of
  /// an older node, that would be a step of its clock.
  bool started_after_newest(const node_status_t& status) const {
    constexpr int64_t kYoung = 1500000, kOtherStart = 50000;  // us
    if (!plausible_utime(status.utime) || !plausible_utime(newest.utime)) return false;
    const int64_t later = (status.utime - newest.utime) - (status.uptime_us - newest.uptime_us);
    return status.uptime_us < newest.uptime_us || (status.uptime_us < kYoung && later > kOtherStart);
  }
  NodeCounters total() const {
    NodeCounters sum{.received = before.received + newest.received,
                     .dropped = before.dropped + newest.dropped,
                     .refused = before.refused + newest.refused,
                     .late = before.late + newest.late,
                     .limited = before.limited + newest.limited,
                     .sent = before.sent + newest.sent};
    for (size_t bin = 0; bin < sum.lateness.size(); ++bin) {
      sum.lateness[bin] = before.lateness[bin] + std::max<int64_t>(newest.lateness[bin], 0);
    }
    return sum;
  }
  /// Messages refused because of their signature.
  RefusalCounts refused_by_name() const {
    RefusalCounts sum = refusals_in(newest.state);
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += refused_before[i];
    return sum;
  }
  /// How late a tick began at most in `share` of all ticks, us, to the upper end of its bin; null without ticks or
  /// where the last bin has no end.
  json lateness_us(double share) const {
    const auto bins = total().lateness;
    const double ticks = static_cast<double>(std::accumulate(bins.begin(), bins.end(), int64_t{0}));
    double sum = 0;
    for (size_t bin = 0; ticks > 0 && bin + 1 < bins.size(); ++bin) {
      sum += static_cast<double>(bins[bin]);
      if (sum >= share * ticks) return int64_t{16} << bin;
    }
    return nullptr;
  }
  json to_json() const {
    const NodeCounters sum = total();
    const RefusalCounts refused = refused_by_name();
    return {{"state", newest.state},
            {"restarts", restarts},
            {"clock_lead_ms", quantile(clock_lead_ms, 0.5)},
            {"received", sum.received},
            {"dropped", sum.dropped},
            {"refused", sum.refused},
            {"refused_unsigned", refused[static_cast<size_t>(Refusal::kUnsigned)]},
            {"refused_altered", refused[static_cast<size_t>(Refusal::kAltered)]},
            {"refused_replayed", refused[static_cast<size_t>(Refusal::kReplayed)]},
            {"refused_other_key", refused[static_cast<size_t>(Refusal::kOtherKey)]},
            {"late", sum.late},
            {"limited", sum.limited},
            {"sent", sum.sent},
            {"build_id", newest.build_id},
            {"lateness_us_p50", lateness_us(0.5)},
            {"lateness_us_p99", lateness_us(0.99)},
            {"lateness_us_p99.9", lateness_us(0.999)},
            {"lateness_bins", sum.lateness}};
  }
};

/// The commands of one start of a bridge, in the order of their receipt.
struct CommandStream {
  robot_bridge::StreamCheck derivatives;  ///< by message time, over periods without a gap
  SpeedWindow speed{};
  int64_t commands = 0, newest_utime = 0;

  /// `robot_utime`: of the newest ROBOT_STATE before it, 0 without one.
  void add(const Chain& chain, int64_t received_utime, int64_t utime, int64_t robot_utime,
           const JointVector& position) {
    if (utime != newest_utime + kPeriodUs) derivatives.begin();
    newest_utime = utime;
    derivatives.add(position);
    speed.add(chain, received_utime, robot_utime, position);
    ++commands;
  }

 private:
  static constexpr int64_t kPeriodUs = 1000;
};

json lost_intervals_of(const std::vector<target_t>& targets, int64_t origin) {
  json intervals = json::array();
  bool lost = false;
  for (const target_t& target : targets) {
    const double time = static_cast<double>(target.utime - origin) * 1e-6;
    if (target.status != target_t::STATUS_TRACKED) {
      if (!lost) intervals.push_back({{"begin_s", time}, {"end_s", time}, {"frames", 0}});
      intervals.back()["end_s"] = time;
      intervals.back()["frames"] = intervals.back()["frames"].get<int>() + 1;
    }
    lost = target.status != target_t::STATUS_TRACKED;
  }
  return intervals;
}

json vision_error_of(const std::vector<target_t>& targets, const std::map<int64_t, target_t>& truths) {
  std::vector<double> errors;
  for (const target_t& target : targets) {
    const auto truth = truths.find(target.pair_sequence);
    if (truth == truths.end() || truth->second.status != target_t::STATUS_TRACKED ||
        target.status != target_t::STATUS_TRACKED)
      continue;
    const Eigen::Vector3d seen = Eigen::Map<const Eigen::Vector3d>(target.position_m);
    errors.push_back(1e3 * (seen - Eigen::Map<const Eigen::Vector3d>(truth->second.position_m)).norm());
  }
  if (errors.empty()) return nullptr;
  return {{"median", quantile(errors, 0.5)},
          {"p95", quantile(errors, 0.95)},
          {"max", quantile(errors, 1)},
          {"frames", errors.size()}};
}

}  // namespace

/// Collects all data for the report in one pass over the messages.
class RunReporter::Data {
 public:
  explicit Data(const RobotConfig& robot)
      : chain(robot.chain), intercept(reach_options_from(robot).intercept), target_name(target_name_from(robot)) {
    const robot_bridge::BridgeOptions bridge = bridge_options_from(robot);
    smooth = bridge.shape == robot_bridge::BridgeOptions::Shape::kSmooth;
    limits_ = robot_bridge::motion_limits(robot.chain, bridge.speed_where_unlimited, bridge.acceleration, bridge.jerk);
  }

  void add(const LogEvent& event) {
    if (!plausible_utime(event.utime)) {
      ++damaged_times;
      return;
    }
    count(event);
  }

  const Chain chain;
  const std::optional<controller::FreeFallFilter::Options> intercept;  // where the hand is to meet thrown targets
  const std::optional<std::string> target_name;
  std::map<std::string, int64_t, std::less<>> counts;
  std::vector<target_t> targets;
  std::map<int64_t, target_t> truths;
  std::vector<TimedPosition> hand;  // measured hand positions, at the times of the commands that the robot had consumed
  double limit_excess = 0, measured_limit_excess = 0, velocity_excess = 0;
  std::map<std::string, NodeRecord> nodes;
  BridgeHalts bridge_halts;
  int64_t first_utime = 0;    // of the first BRIDGE_STATE
  int64_t damaged_times = 0;  // events without a plausible time of receipt: ignored
  /// Runs of the publishers of a channel.
  std::map<std::string, std::set<int64_t>, std::less<>> publishers;
  std::map<std::pair<std::string, int64_t>, SequenceGaps> sequences;  // by channel and run
  std::map<int64_t, CommandStream> command_streams;                   // by the bridge's run
  std::map<int64_t, SpeedWindow> measured_speed;                      // by the robot's run
  bool smooth = true;  // whether the bridge limits accelerations and jerks

 private:
  void count(const LogEvent& event) {
    ++counts[std::string(event.channel)];
    if (event.channel == channel::kTarget) {
      const auto target = decode_and_count_gaps<target_t>(event);
      if (target && plausible_utime(target->utime) && may_be_followed(target->name)) targets.push_back(*target);
    } else if (event.channel == channel::kTargetChoice) {
      if (const auto choice = decode<target_choice_t>(event.data)) choice_ = *choice;
      if (choice_.kind == target_choice_t::NAMED) chosen_names_.insert(choice_.name);
    } else if (event.channel == channel::kTargetTruth) {
      if (const auto truth = decode<target_t>(event.data)) truths[truth->pair_sequence] = *truth;
    } else if (event.channel == channel::kJointSetpoint) {
      decode_and_count_gaps<joint_setpoint_t>(event);
    } else if (event.channel == channel::kJointCommand) {
      add_command(event);
    } else if (event.channel == channel::kRobotState) {
      add_robot_state(event);
    } else if (event.channel == channel::kBridgeState) {
      const auto state = decode<bridge_state_t>(event.data);
      // Before the first ROBOT_STATE the bridge knows no time.
      if (!state || !plausible_utime(state->utime) || state->utime == 0) return;
      if (first_utime == 0) first_utime = state->utime;
      bridge_halts.add(*state);
    } else if (event.channel == channel::kNodeStatus) {
      const auto status = checksum_matches(event.data) ? decode<node_status_t>(event.data) : std::nullopt;
      if (status) nodes[status->node].add(*status, event.utime);
    }
  }

  /// Whether the controller follows a target of this name, as far as TARGET_CHOICE tells.
  bool may_be_followed(const std::string& name) const {
    if (choice_.kind == target_choice_t::NAMED) return name == choice_.name;
    return choice_.kind == target_choice_t::CONFIGURED && !chosen_names_.contains(name);
  }

  template <class Message>
  std::optional<Message> decode_and_count_gaps(const LogEvent& event) {
    auto message = decode<Message>(event.data);
    if (!message) return message;
    const std::string channel(event.channel);
    publishers[channel].insert(message->run);
    sequences[{channel, message->run}].add(message->sequence, event.utime);
    return message;
  }

  void add_command(const LogEvent& event) {
    const auto command = decode_and_count_gaps<joint_command_t>(event);
    if (!command || !plausible_utime(command->utime)) return;
    command_utime_[command->sequence] = command->utime;
    if (const auto theta = from_fields(chain, command->joint_name, command->joint_position)) {
      limit_excess = std::max(limit_excess, chain.limit_excess(*theta));
      command_streams.try_emplace(command->run, CommandStream{.derivatives = robot_bridge::StreamCheck(limits_)})
          .first->second.add(chain, event.utime, command->utime, robot_utime_[command->robot_run], *theta);
    }
    if (const auto velocity = from_fields(chain, command->joint_name, command->joint_velocity)) {
      velocity_excess = std::max(velocity_excess, (velocity->cwiseAbs() - chain.velocity()).maxCoeff());
    }
  }

  void add_robot_state(const LogEvent& event) {
    const auto state = decode_and_count_gaps<robot_state_t>(event);
    if (!state) return;
    const auto theta = from_fields(chain, state->joint_name, state->joint_position);
    if (!theta) return;
    measured_limit_excess = std::max(measured_limit_excess, chain.limit_excess(*theta));
    robot_utime_[state->run] = plausible_utime(state->utime) ? state->utime : 0;
    measured_speed[state->run].add(chain, event.utime, robot_utime_[state->run], *theta);
    const auto command = command_utime_.find(state->command_sequence);
    if (command != command_utime_.end()) hand.push_back({command->second, chain.position(*theta)});
  }

  robot_bridge::MotionLimits limits_;
  std::map<int64_t, int64_t> command_utime_;
  std::map<int64_t, int64_t> robot_utime_;  // of the newest ROBOT_STATE of each of the robot's runs
  target_choice_t choice_{};
  std::set<std::string> chosen_names_;  // that were ever chosen
};

RunReporter::RunReporter(const RobotConfig& robot) : data_(std::make_unique<Data>(robot)) {}

RunReporter::~RunReporter() = default;

void RunReporter::add(const LogEvent& event) {
  data_->add(event);
}

RunReport report_on(const std::string& log_path, const RobotConfig& robot) {
  RunReporter reporter(robot);
  LogReader log(log_path);
  while (const auto event = log.next()) reporter.add(*event);
  return reporter.report();
}

RunReport RunReporter::report() const {
  const Data& run = *data_;
  const auto count = [&run](std::string_view channel) {
    const auto found = run.counts.find(channel);
    return found == run.counts.end() ? int64_t{0} : found->second;
  };
  const int64_t origin = run.targets.empty() ? 0 : run.targets.front().utime;
  const controller::MultiStartIk search(run.chain);
  const JointVector anywhere = run.chain.clamped(JointVector::Zero(run.chain.size()));

  RunReport report;
  json& out = report.json;
  json reaches = json::array(), unreachable = json::array();
  size_t reached = 0;
  // A hand that waits for throws does not go to a target that rests.
  const std::vector<Dwell> dwells = run.intercept ? std::vector<Dwell>{} : dwells_of(run.targets);
  for (const Dwell& dwell : dwells) {
    const json reach = reach_of(dwell, run.hand, origin);
    if (search.nearest(dwell.mean_position(), anywhere)) {
      reaches.push_back(reach);
      reached += reach["hand_error_mm"].is_number() && reach["hand_error_mm"].get<double>() <= 1e3 * kReached;
    } else {
      unreachable.push_back(reach);
    }
  }
  int64_t late = 0, left_out = 0, dropped = 0, refused = 0;
  json nodes = json::object();
  for (const auto& [name, record] : run.nodes) {
    const NodeCounters counters = record.total();
    (name == "vision" ? left_out : late) += counters.late;
    dropped += counters.dropped;
    refused += counters.refused;
    nodes[name] = record.to_json();
  }
  out["images"] = count(channel::kStereoImages);
  out["targets"] = count(channel::kTarget);
  out["setpoints"] = count(channel::kJointSetpoint);
  out["commands"] = count(channel::kJointCommand);
  out["robot_states"] = count(channel::kRobotState);
  out["reaches"] = reaches;
  out["reached"] = reached;
  out["unreachable"] = unreachable;
  // Images with the target, and those of them in which it stayed too short a time, or was seen too unsteadily, for a
  // position to be judged.
  int64_t seen = 0, in_dwells = 0;
  for (const target_t& target : run.targets) seen += target.status == target_t::STATUS_TRACKED;
  for (const Dwell& dwell : dwells) in_dwells += static_cast<int64_t>(dwell.matches.size());
  out["seen"] = seen;
  out["seen_without_position"] = run.intercept ? 0 : seen - in_dwells;
  json flights = json::array();
  if (run.intercept)
    flights = flights_of(run.targets, run.target_name, run.hand, *run.intercept, search, anywhere, origin);
  out["flights"] = flights;
  const auto is_missed = [](const json& flight) {
    return flight["reachable"].get<bool>() &&
           !(flight["closest_mm"].is_number() && flight["closest_mm"].get<double>() <= 1e3 * kMet);
  };
  const auto missed = std::ranges::count_if(flights, is_missed);
  const int64_t bridge_origin = run.targets.empty() ? run.first_utime : origin;
  out["bridge_faults"] = run.bridge_halts.faults_to_json(bridge_origin);
  // The end of a run is a stop, too.
  const int64_t end = run.targets.empty() ? run.first_utime : run.targets.back().utime;
  out["bridge_stops"] = run.bridge_halts.stops_to_json(bridge_origin, end);
  out["lost_intervals"] = lost_intervals_of(run.targets, origin);
  out["vision_error_mm"] = vision_error_of(run.targets, run.truths);
  out["max_limit_violation_rad"] = run.limit_excess;
  out["max_measured_limit_violation_rad"] = run.measured_limit_excess;
  out["max_velocity_violation_rad_s"] = std::max(run.velocity_excess, 0.0);
  double command_speed = 0, acceleration = 0, jerk = 0, measured_speed = 0;
  out["command_streams"] = json::array();
  for (const auto& [run_number, stream] : run.command_streams) {
    out["command_streams"].push_back({{"run", run_number},
                                      {"commands", stream.commands},
                                      {"speed_share", stream.speed.largest()},
                                      {"acceleration_share", stream.derivatives.acceleration()},
                                      {"jerk_share", stream.derivatives.jerk()}});
    command_speed = std::max(command_speed, stream.speed.largest());
    acceleration = std::max(acceleration, stream.derivatives.acceleration());
    jerk = std::max(jerk, stream.derivatives.jerk());
  }
  out["robot_streams"] = json::array();
  for (const auto& [run_number, window] : run.measured_speed) {
    out["robot_streams"].push_back({{"run", run_number}, {"speed_share", window.largest()}});
    measured_speed = std::max(measured_speed, window.largest());
  }
  out["max_command_speed_share"] = command_speed;
  out["max_measured_speed_share"] = measured_speed;
  out["max_command_acceleration_share"] = run.smooth ? json(acceleration) : json();
  out["max_command_jerk_share"] = run.smooth ? json(jerk) : json();
  json publishers = json::object();
  for (const auto& [channel, runs] : run.publishers) publishers[channel] = runs.size();
  out["publishers"] = publishers;
  out["late_ticks"] = late;
  out["pairs_left_out"] = left_out;
  out["lcm_lost"] = dropped;
  int64_t recording_lost = 0, damaged_numbers = 0;
  for (const auto& [channel_and_run, gaps] : run.sequences) {
    recording_lost += gaps.lost();
    damaged_numbers += gaps.damaged();
  }
  out["recording_lost"] = recording_lost;
  out["damaged"] = damaged_numbers + run.damaged_times;
  out["refused"] = refused;
  out["nodes"] = nodes;

  if (run.targets.empty()) {
    report.reason = "no TARGET was recorded";
  } else if (std::ranges::none_of(run.targets,
                                  [](const target_t& target) { return target.status == target_t::STATUS_TRACKED; })) {
    const bool without_pose =
        std::ranges::any_of(run.targets, [](const target_t& t) { return t.status == target_t::STATUS_UNCALIBRATED; });
    report.reason = without_pose ? "the target was seen, but nobody knows where the cameras are: vision.yaml needs "
                                   "cameras.left_to_robot (docs/calibrate.md)"
                                 : "the target was never seen: " + run.targets.back().reason;
  } else if (reaches.empty() && !unreachable.empty()) {
    report.reason = fmt::format("none of the {} positions is within the arm's reach", unreachable.size());
  } else if (reached < reaches.size()) {
    report.reason = fmt::format("{} of {} reachable positions were not reached to {} mm", reaches.size() - reached,
                                reaches.size(), 1e3 * kReached);
    for (const char* node : {"bridge", "robot_driver"}) {
      if (count(channel::kJointCommand) == 0 && run.nodes.contains(node))
        report.reason += fmt::format("; {}: {}", node, run.nodes.at(node).newest.state);
    }
    if (!out["bridge_faults"].empty()) {
      report.reason += "; the bridge was in a fault: " + out["bridge_faults"][0]["cause"].get<std::string>();
    } else if (!out["bridge_stops"].empty()) {
      report.reason += "; the bridge stopped: " + out["bridge_stops"][0]["cause"].get<std::string>();
    }
  } else if (run.limit_excess > 1e-9) {
    report.reason = fmt::format("a command was {:.3g} rad beyond a joint's limit", run.limit_excess);
  } else if (command_speed > kFasterThanTheLimit) {
    report.reason = fmt::format("the commands moved at {:.0f} % of a joint's speed limit, by their time of arrival",
                                100 * command_speed);
  } else if (run.intercept && std::ranges::none_of(flights, [](const json& f) { return f["reachable"].get<bool>(); })) {
    report.reason =
        "no target that falls freely came within the arm's reach (if one did: check the covariance of TARGET, and "
        "gravity_m_s2)";
  } else if (run.intercept && run.hand.empty()) {
    report.reason = "no ROBOT_STATE of this arm was recorded: where the hand was is not known";
  } else if (missed > 0) {
    const auto reachable =
        std::ranges::count_if(flights, [](const json& flight) { return flight["reachable"].get<bool>(); });
    report.reason =
        fmt::format("{} of {} thrown targets that came within the arm's reach passed further than {} mm from the hand",
                    missed, reachable, 1e3 * kMet);
  } else {
    report.succeeded = true;
  }
  return report;
}

}  // namespace multireach
