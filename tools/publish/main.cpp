// multireach-publish: sends a target, an obstacle or a push by hand.
#include <spdlog/spdlog.h>

#include <iostream>
#include <random>

#include "runtime/bus.hpp"
#include "runtime/channels.hpp"
#include "runtime/message.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/program.hpp"
#include "runtime/robot_config.hpp"
#include "tools/publish/messages.hpp"

namespace multireach {
namespace {

struct Arguments {
  LiveOptions live;
  bool once = false;
  double hz = 0;  // 0: the default of the message
  std::string name, robot, shape, link;
  std::vector<double> position, size, orientation{1, 0, 0, 0}, force;
  double duration_s = 0.2;
};

Eigen::Vector3d vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::Vector3d>(values.data());
}

/// Sends what `message` returns for each sequence number: once for `hz` 0, else until the user ends it.
template <class Message>
int publish(const Arguments& arguments, std::string_view channel, double hz, const Message& message) {
  Bus bus(arguments.live.control_url, arguments.live.image_url);
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
  return publish(arguments, channel::kTarget, hz,
                 [&](int64_t utime, int64_t sequence) { return target_message(name, p_WT, utime, sequence, run); });
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
  return publish(arguments, channel::kPerturbation, arguments.once ? 0 : arguments.hz, [&](int64_t utime, int64_t) {
    return perturbation_message(arguments.link, vector_of(arguments.force), arguments.duration_s, utime);
  });
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  // "-.2" would be read as an option, "-0.2" is a number.
  std::vector<std::string> texts(argv, argv + argc);
  std::vector<char*> words;
  for (std::string& text : texts) {
    if (text.starts_with("-.")) text.insert(1, "0");
    words.push_back(text.data());
  }
  Program program("multireach-publish", "Sends a target, an obstacle or a push by hand. Positions in metres, in W.");
  Arguments arguments;
  std::function<int(const Arguments&)> chosen;
  CLI::App& cli = program.cli();
  add_url_options(cli, arguments.live);
  cli.require_subcommand(1);
  auto* once = cli.add_flag("--once", arguments.once, "send one message (default, but for targets)");
  cli.add_option("--hz", arguments.hz, "send so often, until Ctrl-C (default for targets: 30)")
      ->check(finite_range(0.01, 1000))
      ->excludes(once);
  const auto number = finite_range(-1e6, 1e6);

  CLI::App* target = cli.add_subcommand("target", "a target at rest, for the controller")->fallthrough();
  target->add_option("POSITION", arguments.position, "X Y Z, m")->required()->expected(3)->check(number);
  target->add_option("--name", arguments.name, "name of the target (default: that of --robot, else 'target')");
  target->add_option("--robot", arguments.robot, "robot.yaml or its folder, whose controller.target_name is used");
  target->callback([&] { chosen = publish_target; });

  CLI::App* obstacle =
      cli.add_subcommand("obstacle", "one obstacle, which replaces all before; 'none' removes them")->fallthrough();
  obstacle->add_option("SHAPE", arguments.shape, "sphere, capsule, box or none")->required();
  obstacle->add_option("POSITION", arguments.position, "X Y Z of its centre, m")->expected(3)->check(number);
  obstacle->add_option("--size", arguments.size, "m: radius; radius and length; or three lengths")
      ->expected(1, 3)
      ->check(number);
  obstacle->add_option("--orientation", arguments.orientation, "quaternion W X Y Z")->expected(4)->check(number);
  obstacle->callback([&] { chosen = publish_obstacle; });

  CLI::App* push = cli.add_subcommand("perturbation", "a push on a simulated robot")->fallthrough();
  push->add_option("LINK", arguments.link, "the link that is pushed")->required();
  push->add_option("FORCE", arguments.force, "X Y Z, N, in W")->required()->expected(3)->check(number);
  push->add_option("--duration", arguments.duration_s, "s")->check(finite_range(0, 1e6))->capture_default_str();
  push->callback([&] { chosen = publish_push; });
  return program.run(argc, words.data(), [&] { return chosen(arguments); });
}
