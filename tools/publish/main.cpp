// multireach-publish: sends a target, an obstacle or a push by hand, or the images of a session.
#include <spdlog/spdlog.h>

#include <iostream>
#include <random>

#include "runtime/bus.hpp"
#include "runtime/channels.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/program.hpp"
#include "runtime/robot_config.hpp"
#include "tools/publish/messages.hpp"

namespace multireach {
namespace {

struct Arguments {
  BusOptions bus;
  bool once = false;
  double hz = 0;  // 0: the default of the message
  std::string name, robot, shape, link, session;
  std::vector<double> position, size, orientation{1, 0, 0, 0}, target_orientation, force;
  double duration_s = 0.2, speed = 1;
};

Eigen::Vector3d vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::Vector3d>(values.data());
}

/// Sends what `message` returns for each sequence number: once for `hz` 0, else until the user ends it.
template <class Message>
int publish(const Arguments& arguments, std::string_view channel, double hz, const Message& message) {
  Bus bus(arguments.bus);
  catch_signals();
  const int64_t begin = monotonic_us();
  const auto period = static_cast<int64_t>(1e6 / (hz > 0 ? hz : 1));
  for (int64_t sequence = 0; !interrupted(); ++sequence) {
    const auto bytes = encode(message(wall_us(), sequence));
    if (!bytes) return 1;
    bus.publish(channel, *bytes);
    if (hz <= 0) return 0;
    const int64_t next = begin + (sequence + 1) * period;
    while (monotonic_us() < next && !interrupted()) bus.handle_messages(next - monotonic_us(), [] { return false; });
  }
  return 0;
}

/// The name that the controller of `robot` reaches for, where none is given.
std::string target_name(const Arguments& arguments) {
  if (!arguments.name.empty()) return arguments.name;
  if (!arguments.robot.empty()) {
    const RobotConfig robot = RobotConfig::load(arguments.robot);
    if (const auto section = robot.section("controller"); section && section->has("target_name"))
      return section->text("target_name");
  }
  return "target";
}

int publish_target(const Arguments& arguments) {
  std::random_device random;
  const int64_t run = static_cast<int64_t>(random()) + 2;
  const std::string name = target_name(arguments);
  const Eigen::Vector3d p_WT = vector_of(arguments.position);
  const double hz = arguments.once ? 0 : (arguments.hz > 0 ? arguments.hz : 30);
  if (hz > 0) std::cerr << "multireach-publish: sending '" << name << "' until Ctrl-C\n";
  return publish(arguments, channel::kTarget, hz, [&](int64_t utime, int64_t sequence) {
    return target_message(name, p_WT, arguments.target_orientation, utime, sequence, run);
  });
}

int publish_obstacle(const Arguments& arguments) {
  obstacles_t message{};
  if (arguments.shape != "none") {
    if (arguments.position.size() != 3) throw InputError("obstacle: expected X Y Z, in metres, after the shape");
    message.obstacles.push_back(
        obstacle_message(arguments.shape, vector_of(arguments.position), arguments.size, arguments.orientation));
  }
  message.num_obstacles = static_cast<int32_t>(message.obstacles.size());
  return publish(arguments, channel::kObstacles, arguments.once ? 0 : arguments.hz,
                 [&](int64_t utime, int64_t sequence) {
                   message.utime = utime;
                   message.sequence = sequence;
                   return message;
                 });
}

int publish_push(const Arguments& arguments) {
  if (!arguments.robot.empty()) require_link(RobotConfig::load(arguments.robot).urdf_path, arguments.link);
  return publish(arguments, channel::kPerturbation, arguments.once ? 0 : arguments.hz, [&](int64_t utime, int64_t) {
    return perturbation_message(arguments.link, vector_of(arguments.force), arguments.duration_s, utime);
  });
}

/// Like lcm-logplayer, but signed where there is a key.
int publish_session(const Arguments& arguments) {
  LogReader log(arguments.session);
  Bus bus(arguments.bus);
  catch_signals();
  const int64_t begin = monotonic_us();
  std::optional<int64_t> first_utime;
  while (const auto event = log.next()) {
    if (interrupted()) return 130;
    if (event->channel != channel::kStereoImages && event->channel != channel::kTargetTruth) continue;
    if (!first_utime) first_utime = event->utime;
    const double after_us = static_cast<double>(event->utime - *first_utime) / arguments.speed;
    const int64_t next = begin + static_cast<int64_t>(after_us);
    while (monotonic_us() < next && !interrupted()) bus.handle_messages(next - monotonic_us(), [] { return false; });
    bus.publish(event->channel, event->data);
  }
  if (!first_utime) throw InputError(arguments.session + ": holds no STEREO_IMAGES");
  return 0;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  // "-.2" would be read as an option, "-0.2" is a number.
  std::vector<std::string> texts(argv, argv + argc);
  std::vector<char*> words;
  for (std::string& text : texts) {
    if (text.starts_with("-.")) text = "-0" + text.substr(1);
    words.push_back(text.data());
  }
  Program program(
      "multireach-publish",
      "Sends a target, an obstacle or a push by hand, or the images of a session. Positions in metres, in W.");
  Arguments arguments;
  CommandLine& cli = program.cli();
  add_bus_options(cli, arguments.bus);
  cli.require_subcommand();
  const CommandOption once = cli.flag("--once", arguments.once, "send one message (default, but for targets)");
  cli.option("--hz", arguments.hz, "messages per second, until Ctrl-C (default for targets: 30)")
      .finite(0.01, 1000)
      .excludes(once);
  constexpr double kLargest = 1e6;

  CommandLine target = cli.subcommand("target", "a target at rest, for the controller");
  target.option("POSITION", arguments.position, "position of the target, m, in W")
      .required()
      .values(3, "X Y Z")
      .finite(-kLargest, kLargest);
  target.option("--orientation", arguments.target_orientation, "rotation from the target's frame to W, unit quaternion")
      .values(4, "W X Y Z")
      .finite(-kLargest, kLargest);
  target.option("--name", arguments.name, "name of the target (default: that of --robot, else 'target')");
  const std::string robot = "robot.yaml or its folder: ";
  target.option("--robot", arguments.robot, robot + "its controller.target_name is used");

  CommandLine obstacle = cli.subcommand("obstacle", "one obstacle, which replaces all before; 'none' removes them");
  obstacle.option("SHAPE", arguments.shape, "sphere, capsule, box or none").required();
  obstacle.option("POSITION", arguments.position, "centre of the obstacle, m, in W")
      .values(3, "X Y Z")
      .finite(-kLargest, kLargest);
  obstacle
      .option("--size", arguments.size, "m: radius of a sphere; radius and length of a capsule; three lengths of a box")
      .values(1, 3, "LENGTH")
      .finite(-kLargest, kLargest);
  obstacle.option("--orientation", arguments.orientation, "orientation of the obstacle in W, unit quaternion")
      .values(4, "W X Y Z")
      .finite(-kLargest, kLargest);

  CommandLine push = cli.subcommand("perturbation", "a push on a simulated robot");
  push.option("LINK", arguments.link, "the link that is pushed").required();
  push.option("FORCE", arguments.force, "force, N, in W").required().values(3, "X Y Z").finite(-kLargest, kLargest);
  push.option("--robot", arguments.robot, robot + "its URDF must have the link");
  push.option("--duration", arguments.duration_s, "how long the push lasts, s").finite(0, kLargest).show_default();

  CommandLine session = cli.subcommand("session", "the images of a recorded session (STEREO_IMAGES, TARGET_TRUTH)");
  session.option("LOG", arguments.session, "the session").required();
  session.option("--speed", arguments.speed, "seconds of the session per second").finite(0.01, 100).show_default();
  for (CommandLine* word : {&target, &obstacle, &push, &session}) word->fallthrough();
  return program.run(argc, words.data(), [&] {
    if (target.given()) return publish_target(arguments);
    if (session.given()) return publish_session(arguments);
    return obstacle.given() ? publish_obstacle(arguments) : publish_push(arguments);
  });
}
