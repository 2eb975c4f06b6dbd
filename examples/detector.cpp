// A detector of your own: publishes one target, "mine", on channel TARGET, with plain LCM and the generated types.
// Replace the circle by what your detector finds. The controller follows it with `target_name: mine` in the robot.yaml.
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <multireach/target_t.hpp>
#include <random>

int main(int argc, char** argv) {
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 300;  // at 30 Hz
  lcm::LCM lcm;                                           // LCM_DEFAULT_URL, else LCM's default group
  if (!lcm.good()) return 1;
  multireach::target_t target{};
  target.run = static_cast<int64_t>(std::random_device{}()) + 2;  // tells this start of the detector from all others
  target.name = "mine";                                           // no other process may publish this name
  target.left_frame_utime = target.right_frame_utime = target.pair_sequence = -1;
  for (int k = 0; k < pairs; ++k, ++target.sequence) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    target.utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();  // capture time of your images
    target.status = multireach::target_t::STATUS_TRACKED;  // STATUS_LOST, with a reason, where nothing is seen
    target.reason = "seen";
    target.last_seen_utime = target.utime;
    target.position_m[0] = 0.1 + 0.01 * std::cos(0.02 * k);  // in the robot's base frame W
    target.position_m[1] = -0.12 + 0.01 * std::sin(0.02 * k);
    target.position_m[2] = 0.1;
    for (int i = 0; i < 3; ++i) target.covariance_m2[i][i] = 1e-6;  // 1 mm: the controller filters by it
    lcm.publish("TARGET", &target);
    usleep(33333);
  }
}
