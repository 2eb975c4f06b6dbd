// multireach-robot: asks the bridge to enable, disable, pause, resume, slow down or reset, and prints its answer.
#include <spdlog/spdlog.h>

#include <iostream>
#include <multireach/bridge_request_t.hpp>
#include <multireach/bridge_state_t.hpp>
#include <random>

#include "runtime/bus.hpp"
#include "runtime/channels.hpp"
#include "runtime/message.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/program.hpp"
#include "tools/robot/bridge_words.hpp"

namespace multireach {
namespace {

constexpr int64_t kTimeout = 2000000;      // us
constexpr int64_t kRepeatPeriod = 200000;  // us: a request that was lost is sent again
constexpr int64_t kSilence = 500000;       // us: a robot that sends nothing for so long is not there

/// Sends a request until the bridge answers; nothing when it does not.
std::optional<bridge_state_t> answer_to(bridge_request_t request, Bus& bus, std::optional<bridge_state_t>& newest) {
  std::random_device random;
  request.request = static_cast<int64_t>(random()) + 1;
  newest.reset();
  const auto answered = [&] { return newest && newest->request == request.request; };
  const int64_t begin = monotonic_us();
  for (int64_t sent = begin - kRepeatPeriod; !answered() && !interrupted();) {
    const int64_t now = monotonic_us();
    if (now - begin > kTimeout) return std::nullopt;
    if (now - sent >= kRepeatPeriod) {
      sent = now;
      request.utime = wall_us();
      if (const auto bytes = encode(request)) bus.publish(channel::kBridgeRequest, *bytes);
    }
    bus.handle_messages(kRepeatPeriod, answered);
  }
  return answered() ? newest : std::nullopt;
}

/// Asks the bridge for its run, then sends it the request. Returns the program's exit code.
int ask(bridge_request_t request, const BusOptions& options) {
  Bus bus(options);
  std::optional<bridge_state_t> newest;
  bus.subscribe(channel::kBridgeState, "robot", [&](std::string_view, std::span<const uint8_t> bytes) {
    if (auto state = decode<bridge_state_t>(bytes)) newest = std::move(*state);
  });
  bool heard = false;
  bus.subscribe(channel::kRobotState, "robot", [&](std::string_view, std::span<const uint8_t>) { heard = true; });
  bridge_request_t status{};
  status.kind = bridge_request_t::STATUS;
  auto answer = answer_to(status, bus, newest);
  if (answer && request.kind != bridge_request_t::STATUS) {
    request.run = run_asked(request.kind, answer->run);
    answer = answer_to(request, bus, newest);
  }
  if (!answer) {
    std::cerr << "multireach-robot: no answer; is multireach-bridge running on this LCM group, with the same --key?\n";
    return 1;
  }
  std::cout << text_of(*answer) << "\n";
  if (!answer->request_accepted) {
    std::cerr << "multireach-robot: " << refusal_of(request.kind) << "\n";
    return 1;
  }
  if (!asks_to_move(request.kind)) return 0;
  for (const int64_t begin = monotonic_us(); !heard && !interrupted() && monotonic_us() - begin < kSilence;)
    bus.handle_messages(kSilence, [&] { return heard; });
  if (heard) return 0;
  std::cerr << "multireach-robot: no ROBOT_STATE arrives, so nothing moves; is the robot, or its driver, running?\n";
  return 1;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-robot", "Enables, pauses, slows down, stops and resets the robot through the bridge.");
  BusOptions options;
  add_bus_options(program.cli(), options);
  program.cli().require_subcommand();
  std::vector<std::pair<CommandLine, int8_t>> kinds;
  for (const BridgeWord& word : bridge_words())
    kinds.emplace_back(program.cli().subcommand(word.word, word.help), word.kind);
  double percent = 100;
  kinds.emplace_back(program.cli().subcommand("speed", "set the speed override"), bridge_request_t::SPEED);
  kinds.back().first.option("PERCENT", percent, "speed override, per cent; 0 pauses").required().finite(0, 100);
  for (auto& [command, kind] : kinds) command.fallthrough();
  return program.run(argc, argv, [&] {
    bridge_request_t request{};
    for (const auto& [command, kind] : kinds) {
      if (command.given()) request.kind = kind;
    }
    if (request.kind == bridge_request_t::SPEED) request.speed = percent / 100;
    catch_signals();
    return ask(request, options);
  });
}
