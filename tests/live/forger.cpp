// Pretends to be the controller or the bridge that it hears.
//   multireach-test-forger setpoints N   N set-points, each 0.95 s later than the one before and 0.8 rad away
//   multireach-test-forger commands S    commands beside those of the bridge, 0.5 rad to and fro, for S seconds; prints
//   their run
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <multireach/joint_command_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <optional>
#include <string>

#include "runtime/channels.hpp"

namespace multireach {
namespace {

template <class Message>
class Newest {
 public:
  Newest(lcm::LCM& bus, std::string_view channel) : bus_(&bus) {
    bus.subscribe(std::string(channel), &Newest::hear, this);
  }
  /// Waits for five seconds at most.
  std::optional<Message> wait() {
    for (int k = 0; k < 50 && !message_; ++k) bus_->handleTimeout(100);
    return message_;
  }

 private:
  void hear(const lcm::ReceiveBuffer*, const std::string&, const Message* message) { message_ = *message; }
  lcm::LCM* bus_;
  std::optional<Message> message_;
};

int forge_setpoints(lcm::LCM& bus, int number) {
  auto message = Newest<joint_setpoint_t>(bus, channel::kJointSetpoint).wait();
  if (!message) return 1;
  for (int k = 0; k < number; ++k) {
    message->utime += 950000;
    ++message->sequence;
    for (double& position : message->joint_position) position += 0.8;
    bus.publish(std::string(channel::kJointSetpoint), &*message);
  }
  return 0;
}

int forge_commands(lcm::LCM& bus, double seconds) {
  auto message = Newest<joint_command_t>(bus, channel::kJointCommand).wait();
  if (!message) return 1;
  const auto begin = message->joint_position;
  message->run ^= 1;
  std::printf("%lld\n", static_cast<long long>(message->run));
  const timespec millisecond{0, 1000000};
  for (int k = 0; k < seconds * 1000; ++k) {
    message->utime += 1000;
    ++message->sequence;
    for (size_t i = 0; i < begin.size(); ++i) message->joint_position[i] = begin[i] + 0.5 * std::sin(0.05 * k);
    bus.publish(std::string(channel::kJointCommand), &*message);
    nanosleep(&millisecond, nullptr);
  }
  return 0;
}

int forge(const std::string& what, double number) {
  lcm::LCM bus("udpm://239.255.76.67:7667?ttl=0");
  if (!bus.good()) return 1;
  const int code = what == "setpoints" ? forge_setpoints(bus, static_cast<int>(number)) : forge_commands(bus, number);
  if (code != 0) std::fputs("nothing to pretend was heard\n", stderr);
  return code;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  return multireach::forge(argv[1], std::atof(argv[2]));
}
