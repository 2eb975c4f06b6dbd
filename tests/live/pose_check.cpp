// multireach-test-pose LOG ROBOT: how far the hand is from the true pose of the target, at the end of each rest of 3 s
// or longer. Exit code 1 unless there are three of them, within 2 mm and 1 degree.
#include <cstdio>
#include <numbers>

#include "runtime/robot_config.hpp"
#include "tests/tools/pose_errors.hpp"

int main(int argc, char** argv) {
  using namespace multireach;
  if (argc != 3) return 2;
  const std::vector<PoseError> errors = pose_errors(argv[1], RobotConfig::load(argv[2]).chain, 3);
  bool near = errors.size() == 3;
  for (const PoseError& error : errors) {
    const double degrees = error.angle_rad * 180 / std::numbers::pi;
    std::printf("%6.2f s: %.3f mm, %.3f degrees\n", error.at_s, 1e3 * error.position_m, degrees);
    near = near && error.position_m < 0.002 && degrees < 1;
  }
  return near ? 0 : 1;
}
