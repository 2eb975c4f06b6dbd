#include <fmt/format.h>

#include <cmath>

#include "tools/log/run_report.hpp"

namespace multireach {
namespace {

using nlohmann::json;

/// A clock that differs by more is reported: far more than a message takes on a busy machine.
constexpr double kSameClock = 20;  // ms
/// The shortest lateness that is counted and longer than the gap from which on the bridge's commands begin again from
/// rest.
constexpr double kBeginsAgain = 4096;  // us

/// Lateness of the nodes' ticks, their clocks and restarts.
std::string lines_on_nodes(const json& nodes) {
  std::string lines;
  for (const auto& [name, node] : nodes.items()) {
    if (!node["lateness_us_p50"].is_number()) continue;
    const auto under = [&node = node](const char* share) {
      return node[share].is_number() ? "< " + node[share].dump() + " us" : std::string("> 16384 us");
    };
    lines += fmt::format("ticks of {} began late by {} (99 %), {} (99.9 %)\n", name, under("lateness_us_p99"),
                         under("lateness_us_p99.9"));
    const json& late = node["lateness_us_p99"];
    if (name == "bridge" && !(late.is_number() && late <= kBeginsAgain))
      lines +=
          "the bridge is late so often that the arm may crawl: after each gap of more than 3 ms it begins again from "
          "rest\n";
  }
  std::string restarts;
  for (const auto& [name, node] : nodes.items()) {
    if (node["restarts"] > 0) restarts += (restarts.empty() ? "" : ", ") + name + " " + node["restarts"].dump();
  }
  for (const auto& [name, node] : nodes.items()) {
    const double lead = node["clock_lead_ms"].is_number() ? node["clock_lead_ms"].get<double>() : 0;
    if (!(std::abs(lead) > kSameClock)) continue;  // NaN: no clock was told
    lines += fmt::format("clock of {}: {:.0f} ms {} the recorder's\n", name, std::abs(lead),
                         lead > 0 ? "ahead of" : "behind");
  }
  for (const auto& [name, node] : nodes.items()) {
    std::string refused;
    for (const auto& [key, text] :
         {std::pair("refused_unsigned", "unsigned"), std::pair("refused_altered", "altered"),
          std::pair("refused_replayed", "replayed"), std::pair("refused_other_key", "of another key")}) {
      if (node[key] > 0) refused += fmt::format("{}{} {}", refused.empty() ? "" : ", ", node[key].dump(), text);
    }
    if (!refused.empty()) lines += fmt::format("{} refused messages: {}\n", name, refused);
  }
  if (!restarts.empty()) lines += "restarts: " + restarts + "\n";
  return lines;
}

}  // namespace

std::string table_of(const json& report) {
  const auto number = [](const json& value, const char* format) {
    return value.is_number() ? fmt::format(fmt::runtime(format), value.get<double>()) : std::string("-");
  };
  std::string table = "\n";
  if (!report["reaches"].empty() || !report["unreachable"].empty() || report["flights"].empty())
    table += fmt::format("{:<24}{:>10}{:>12}{:>12}\n", "position (m, in W)", "dwell (s)", "error (mm)", "settle (s)");
  for (const char* list : {"reaches", "unreachable"}) {
    for (const json& reach : report[list]) {
      const json& p = reach["target_m"];
      const std::string position =
          fmt::format("{:6.3f} {:6.3f} {:6.3f}", p[0].get<double>(), p[1].get<double>(), p[2].get<double>());
      table += fmt::format("{:<24}{:>10.1f}{:>12}{:>12}{}\n", position,
                           reach["end_s"].get<double>() - reach["begin_s"].get<double>(),
                           number(reach["hand_error_mm"], "{:.2f}"), number(reach["settle_s"], "{:.2f}"),
                           list == std::string("reaches") ? "" : "  unreachable");
    }
  }
  const int64_t seen = report["seen"].get<int64_t>(), moving = report["seen_without_position"].get<int64_t>();
  if (4 * moving > seen) {
    table += fmt::format(
        "in {} of {} images the target moved, or was seen too unsteadily (8 mm, 1 s), for a position to be judged\n",
        moving, seen);
  }
  for (const json& flight : report["flights"]) {
    table += fmt::format("thrown target falls from {:.2f} to {:.2f} s: the hand is within {} mm at {} s{}\n",
                         flight["begin_s"].get<double>(), flight["end_s"].get<double>(),
                         number(flight["closest_mm"], "{:.1f}"), number(flight["closest_s"], "{:.2f}"),
                         flight["reachable"].get<bool>() ? "" : "  unreachable");
  }
  for (const json& lost : report["lost_intervals"]) {
    const auto frames = lost["frames"].get<int>();
    table += frames == 1 ? fmt::format("target not seen at {:.2f} s (1 frame)\n", lost["begin_s"].get<double>())
                         : fmt::format("target not seen from {:.2f} to {:.2f} s ({} frames)\n",
                                       lost["begin_s"].get<double>(), lost["end_s"].get<double>(), frames);
  }
  for (const json& fault : report["bridge_faults"]) {
    table += fmt::format("bridge in a fault from {:.2f} s: {}\n", fault["at_s"].get<double>(),
                         fault["cause"].get<std::string>());
  }
  for (const json& stop : report["bridge_stops"]) {
    table +=
        fmt::format("bridge stopped at {:.2f} s: {}\n", stop["at_s"].get<double>(), stop["cause"].get<std::string>());
  }
  if (report["vision_error_mm"].is_object()) {
    const json& error = report["vision_error_mm"];
    table += fmt::format("vision against truth: median {:.2f} mm, 95 % {:.2f}, max {:.2f}\n",
                         error["median"].get<double>(), error["p95"].get<double>(), error["max"].get<double>());
  }
  table += fmt::format("images {}, targets {}, set-points {}, commands {}, robot states {}\n", report["images"].dump(),
                       report["targets"].dump(), report["setpoints"].dump(), report["commands"].dump(),
                       report["robot_states"].dump());
  table += fmt::format(
      "beyond a position limit: commands {:.3g}, robot {:.3g} rad; speed, by time of arrival: commands {:.0f} %, "
      "robot {:.0f} % of the limit\n",
      report["max_limit_violation_rad"].get<double>(), report["max_measured_limit_violation_rad"].get<double>(),
      100 * report["max_command_speed_share"].get<double>(), 100 * report["max_measured_speed_share"].get<double>());
  if (report["max_command_jerk_share"].is_number()) {
    table += fmt::format("commands, by message time: acceleration {:.0f} %, jerk {:.0f} % of the limit\n",
                         100 * report["max_command_acceleration_share"].get<double>(),
                         100 * report["max_command_jerk_share"].get<double>());
  }
  table += fmt::format("late ticks {}; pairs left out by vision {}; messages lost {}, not recorded {}; refused {}\n",
                       report["late_ticks"].dump(), report["pairs_left_out"].dump(), report["lcm_lost"].dump(),
                       report["recording_lost"].dump(), report["refused"].dump());
  table += lines_on_nodes(report["nodes"]);
  if (report["damaged"].get<int64_t>() > 0) {
    table += fmt::format("{} messages have damaged sequence numbers or times; `check` tells more\n",
                         report["damaged"].dump());
  }
  for (const auto& [channel, runs] : report["publishers"].items()) {
    if (runs.get<int>() > 1)
      table += fmt::format("{}: {} publishers, or one that was restarted\n", channel, runs.dump());
  }
  return table;
}

}  // namespace multireach
