// multireach-robot: asks the bridge to enable, disable, pause, resume, slow down or reset, and prints its answer.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>
#include <iostream>
#include <multireach/bridge_request_t.hpp>
#include <multireach/bridge_state_t.hpp>
#include <multireach/controller_state_t.hpp>
#include <random>
#include <tuple>

#include "runtime/bus.hpp"
#include "runtime/channels.hpp"
#include "runtime/message.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/program.hpp"
#include "tools/robot/bridge_asker.hpp"
#include "tools/robot/bridge_words.hpp"

namespace multireach {
namespace {

/// Whether the hand is where it shall be, by what the controller said last.
std::string text_of(const std::optional<controller_state_t>& state) {
  if (!state) return "controller: silent";
  const auto mode = static_cast<size_t>(state->mode);
  static constexpr std::array kModes{"waiting for a target", "reaching", "holding", "resting"};
  std::string text = fmt::format("controller: {}", mode < kModes.size() ? kModes[mode] : "unknown");
  if (state->mode != controller_state_t::MODE_WAITING)
    text += fmt::format(", hand {:.1f} mm from the target", 1e3 * state->distance_m);
  if (state->target_lost) text += " as last seen";
  if (state->target_unreachable) text += ", which is unreachable";
  if (state->blocked != controller_state_t::BLOCKED_NO) text += "; blocked";
  return text;
}

/// Asks, and prints the answer. Returns the program's exit code.
int ask(const std::string& word, int8_t kind, double speed, const BusOptions& options) {
  Bus bus(options);
  std::random_device random;
  BridgeAsker asker(static_cast<int64_t>(random()) << 16 | 1);
  bus.subscribe(channel::kBridgeState, "robot", [&](std::string_view, std::span<const uint8_t> bytes) {
    if (const auto state = decode<bridge_state_t>(bytes)) asker.receive(*state);
  });
  bus.subscribe(channel::kRobotState, "robot",
                [&](std::string_view, std::span<const uint8_t>) { asker.receive_robot_state(); });
  std::optional<controller_state_t> controller;
  if (kind == bridge_request_t::STATUS) {
    bus.subscribe(channel::kControllerState, "robot", [&](std::string_view, std::span<const uint8_t> bytes) {
      if (auto state = decode<controller_state_t>(bytes)) controller = std::move(*state);
    });
  }
  asker.ask(word, kind, speed);
  std::optional<BridgeAnswer> answer;
  while (!answer && !interrupted()) {
    if (auto request = asker.tick(monotonic_us())) {
      request->utime = wall_us();
      if (const auto bytes = encode(*request)) bus.publish(channel::kBridgeRequest, *bytes);
    }
    bus.handle_messages(BridgeAsker::kTickUs, [] { return interrupted(); });
    answer = asker.take_answer();
  }
  if (!answer) return 1;
  if (!answer->state.empty()) std::cout << answer->state << "\n";
  if (!answer->state.empty() && kind == bridge_request_t::STATUS) std::cout << text_of(controller) << "\n";
  if (!answer->problem.empty()) std::cerr << "multireach-robot: " << answer->problem << "\n";
  return answer->accepted ? 0 : 1;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-robot", "Enables, pauses, slows down, stops and resets the robot through the bridge.");
  BusOptions options;
  add_bus_options(program.cli(), options);
  program.cli().require_subcommand();
  std::vector<std::tuple<CommandLine, std::string, int8_t>> kinds;
  for (const BridgeWord& word : bridge_words())
    kinds.emplace_back(program.cli().subcommand(word.word, word.help), word.word, word.kind);
  double percent = 100;
  kinds.emplace_back(program.cli().subcommand("speed", "set the speed override"), "speed", bridge_request_t::SPEED);
  std::get<CommandLine>(kinds.back())
      .option("PERCENT", percent, "speed override, per cent; 0 pauses")
      .required()
      .finite(0, 100);
  for (auto& kind : kinds) std::get<CommandLine>(kind).fallthrough();
  return program.run(argc, argv, [&] {
    std::string word;
    int8_t kind = bridge_request_t::STATUS;
    for (const auto& [command, name, number] : kinds) {
      if (!command.given()) continue;
      word = name;
      kind = number;
    }
    catch_signals();
    return ask(word, kind, percent / 100, options);
  });
}
