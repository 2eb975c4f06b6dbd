// multireach-page: serves a page on which a browser shows the robot, the cameras and all nodes, live or of a log.
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "runtime/message_clock.hpp"
#include "runtime/program.hpp"
#include "runtime/rig_config.hpp"
#include "tools/page/listening_socket.hpp"
#include "tools/page/log_answers.hpp"
#include "tools/page/log_page.hpp"
#include "tools/page/page_node.hpp"
#include "tools/page/page_server.hpp"
#include "tools/page/setup_text.hpp"
#include "tools/replay/request.hpp"

namespace multireach {
namespace {

// With these a page stays at its address when this process is started again, and can be reached from outside of the
// network namespace that it runs in.
constexpr const char* kSocketVariable = "MULTIREACH_PAGE_SOCKET";
constexpr const char* kTokenVariable = "MULTIREACH_PAGE_TOKEN";
constexpr const char* kAddressVariable = "MULTIREACH_PAGE_ADDRESS";  // for who opens a browser

struct Arguments {
  std::string robot, vision, course, folder, address = "127.0.0.1", name, log;
  int port = 0;
  bool practice = false, drake = false;
  std::vector<std::string> compared;
  std::vector<std::string> command;
};

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::string token() {
  const std::string given = variable(kTokenVariable);
  return given.empty() ? random_token() : given;
}

std::string print_address(const Arguments& arguments, int port, const std::string& secret) {
  const std::string host = !arguments.name.empty() ? arguments.name : arguments.address;
  const std::string address =
      "http://" + (host == "0.0.0.0" ? "127.0.0.1" : host) + ":" + std::to_string(port) + "/#" + secret;
  std::cout << address << std::endl;
  return address;
}

/// Opens the socket, then becomes the command, whose page uses it.
int run_with_socket(const Arguments& arguments) {
  const int socket = open_listening_socket(arguments.address, arguments.port);
  const std::string secret = token();
  setenv(kSocketVariable, std::to_string(socket).c_str(), 1);
  setenv(kTokenVariable, secret.c_str(), 1);
  setenv(kAddressVariable, print_address(arguments, listening_port(socket), secret).c_str(), 1);
  run_instead(arguments.command);
}

/// The folder with the built page: beside the builds of the source tree, or of the installation.
std::string page_folder(const std::string& given) {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  std::vector<std::filesystem::path> folders{given};
  if (given.empty()) folders = {program / "../../web", program / "../share/multireach/web"};
  for (const auto& folder : folders) {
    if (std::filesystem::exists(folder / "index.html", error)) return folder.lexically_normal().string();
  }
  throw InputError("the page was not found in '" + folders[0].lexically_normal().string() +
                   "': expected index.html there; build it with  tools/setup.sh page");
}

int socket_of_environment() {
  const std::string text = variable(kSocketVariable);
  if (text.empty()) return -1;
  int socket = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), socket);
  if (error != std::errc() || end != text.data() + text.size())
    throw InputError(std::string(kSocketVariable) + ": '" + text + "' is no descriptor of a socket");
  return socket;
}

/// A server of the page, with all options that do not depend on what it shows.
PageServer::Options server_options(const Arguments& arguments) {
  return {.folder = page_folder(arguments.folder),
          .address = arguments.address,
          .port = arguments.port,
          .socket = socket_of_environment(),
          .access = {.token = token(), .host = arguments.name}};
}

void print_address(const Arguments& arguments, const PageServer& server, const PageServer::Options& options) {
  if (options.socket < 0) print_address(arguments, server.port(), options.access.token);
}

int serve_live(const Arguments& arguments, LiveOptions live) {
  const RobotConfig robot = RobotConfig::load(arguments.robot);
  std::optional<RigConfig> rig;
  if (!arguments.vision.empty()) rig = load_rig(Config::load(arguments.vision).section("cameras"));
  PageServer::Options options = server_options(arguments);
  options.greeting = setup_text(robot, rig ? &rig->rig : nullptr);
  FoxgloveHub foxglove;
  options.foxglove = &foxglove;
  PageServer server(options);
  print_address(arguments, server, options);
  std::random_device random;
  PageNode node(server, {.utime = wall_us(),
                         .first_request = static_cast<int64_t>(random()) + 1,
                         .run = static_cast<int64_t>(random()) + 2});
  node.feed_foxglove(foxglove, robot, rig && rig->has_robot_pose ? &rig->rig : nullptr);
  if (arguments.drake) node.feed_drake(robot);
  if (!arguments.course.empty()) node.offer_course(robot, arguments.course, arguments.practice);
  live.speed = 1;  // its ticks are those of the wall clock
  live.drain_period_us = PageNode::kTickUs;
  return run_live(node, live);
}

/// Cameras of a log whose vision.yaml is missing or broken are not drawn.
std::optional<RigConfig> rig_for_log(const std::string& vision, bool required) {
  try {
    return load_rig(Config::load(vision).section("cameras"));
  } catch (const InputError&) {
    if (required) throw;
    return std::nullopt;
  }
}

int serve_log(const Arguments& arguments) {
  constexpr auto kStep = std::chrono::milliseconds(40);
  Setup files;
  files.config = arguments.robot;
  files.vision = arguments.vision;
  const RobotConfig robot = RobotConfig::load(files.robot_file());
  const auto rig = rig_for_log(files.vision_file(arguments.log), !arguments.vision.empty());
  ShownRuns runs({.log = arguments.log, .robot = arguments.robot, .vision = arguments.vision});
  for (const std::string& path : arguments.compared) runs.add_log(path);
  const LogAnswers answers(runs);
  PageServer::Options options = server_options(arguments);
  auto greeting = nlohmann::ordered_json::parse(setup_text(robot, rig ? &rig->rig : nullptr));
  greeting["setup"]["log"] = std::filesystem::path(arguments.log).filename().string();
  options.greeting = greeting.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  options.answer = [&](std::string_view path, std::string_view query) { return answers.answer(path, query); };
  PageServer server(options);
  print_address(arguments, server, options);
  LogPage page(server, runs);
  catch_signals();
  while (!interrupted()) {
    page.step();
    std::this_thread::sleep_for(kStep);
  }
  return 0;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  Program program(
      "multireach-page",
      "Serves a page on which a browser shows the robot, the cameras and all nodes, live or of a recorded log, and "
      "prints its address.");
  Arguments arguments;
  CommandLine& cli = program.cli();
  cli.option("--robot", arguments.robot, "robot.yaml or its folder, as robots/hoap2");
  cli.option("--vision", arguments.vision, "vision.yaml, for the cameras' poses");
  cli.option("--log", arguments.log,
             "recorded log to show instead of a running system; then --robot and --vision default as in "
             "multireach-replay run");
  cli.option("--compare", arguments.compared, "with --log: another log of the same session; may be repeated")
      .repeated();
  cli.option("--course", arguments.course,
             "offer the set-up course, whose files are in this folder (docs/calibrate.md)");
  cli.flag("--practice", arguments.practice, "with --course: tell `multireach-camera practice` what to show");
  cli.flag("--drake", arguments.drake, "also send the arm, targets and obstacles to Drake's viewer meldis");
  cli.option("--page", arguments.folder, "folder of the built page (default: build/web)");
  cli.option("--host", arguments.address, "IPv4 address to listen at; 0.0.0.0 lets other computers in").show_default();
  cli.option("--host-name", arguments.name, "a name of this computer that browsers may use besides its addresses");
  cli.option("--port", arguments.port, "0: any that is free").whole(0, 65535).show_default();
  cli.option("COMMAND", arguments.command,
             "after --: open the socket, then run this command, whose multireach-page serves it, e.g. in a network "
             "namespace");
  const LiveOptions& live = program.add_live_options();
  return program.run(argc, argv, [&] {
    if (!arguments.command.empty()) return run_with_socket(arguments);
    if (arguments.drake && !arguments.log.empty()) throw InputError("--drake: is not allowed with --log");
    if (!arguments.log.empty()) return serve_log(arguments);
    if (!arguments.compared.empty()) throw InputError("--compare: is only allowed with --log");
    if (arguments.robot.empty()) throw InputError("--robot is required");
    return serve_live(arguments, live);
  });
}
