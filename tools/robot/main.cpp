// multireach-robot: asks the bridge to enable, disable, pause, resume, slow down or reset, and prints its answer.
#include <poll.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <iostream>
#include <multireach/bridge_request_t.hpp>
#include <multireach/bridge_state_t.hpp>
#include <multireach/controller_state_t.hpp>
#include <multireach/node_status_t.hpp>
#include <random>
#include <tuple>

#include "runtime/bus.hpp"
#include "runtime/channels.hpp"
#include "runtime/message.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/program.hpp"
#include "tools/robot/bridge_asker.hpp"
#include "tools/robot/bridge_words.hpp"
#include "tools/robot/hand_status.hpp"

namespace multireach {
namespace {

/// Whether nobody reads standard output any more: after its first line, `grep -q` has ended.
bool nobody_reads() {
  pollfd output{STDOUT_FILENO, 0, 0};
  return poll(&output, 1, 0) > 0 && (output.revents & POLLERR) != 0;
}

/// Asks, and prints the answer; for `status`, what the controller says in a second line. Returns the program's exit
/// code.
int ask(const std::string& word, int8_t kind, double speed, const BusOptions& options) {
  Bus bus(options);
  std::random_device random;
  BridgeAsker asker(static_cast<int64_t>(random()) << 16 | 1);
  bus.subscribe(channel::kBridgeState, "robot", [&](std::string_view, std::span<const uint8_t> bytes) {
    if (const auto state = decode<bridge_state_t>(bytes)) asker.receive(*state);
  });
  bool robot_heard = false;
  bus.subscribe(channel::kRobotState, "robot", [&](std::string_view, std::span<const uint8_t>) {
    asker.receive_robot_state();
    robot_heard = true;
  });
  const int64_t begun_us = monotonic_us();
  HandStatus hand(begun_us);
  if (kind == bridge_request_t::STATUS) {
    bus.subscribe(channel::kControllerState, "robot", [&](std::string_view, std::span<const uint8_t> bytes) {
      if (const auto state = decode<controller_state_t>(bytes)) hand.receive(*state);
    });
    bus.subscribe(channel::kNodeStatus, "robot", [&](std::string_view, std::span<const uint8_t> bytes) {
      if (const auto status = decode<node_status_t>(bytes)) hand.receive(*status);
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
  if (!answer->state.empty()) std::cout << answer->state << std::endl;  // at once, for who reads this line only
  if (!answer->problem.empty()) std::cerr << "multireach-robot: " << answer->problem << "\n";
  if (kind == bridge_request_t::STATUS && !answer->state.empty()) {
    // Who reads the first line only must not be told that the program failed.
    std::signal(SIGPIPE, SIG_IGN);
    std::optional<std::string> line;
    const auto robot_known = [&] { return robot_heard || monotonic_us() - begun_us > BridgeAsker::kRobotTime; };
    while ((!(line = hand.line(monotonic_us())) || !robot_known()) && !interrupted() && !nobody_reads())
      bus.handle_messages(BridgeAsker::kTickUs, [] { return interrupted(); });
    if (line) {
      *line += '\n';
      if (write(STDOUT_FILENO, line->data(), line->size()) < 0 && errno != EPIPE) std::cout.setstate(std::ios::badbit);
    }
    if (!robot_heard && robot_known()) std::cerr << "multireach-robot: no ROBOT_STATE arrives: the robot is silent\n";
  }
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
