#pragma once

#include <multireach/joint_command_t.hpp>

#include "runtime/followed_run.hpp"
#include "runtime/node.hpp"

namespace multireach {

/// Which commands a robot obeys: those that name the robot's own run, of one bridge at a time.
class CommandFilter {
 public:
  /// Whether the robot of run `robot_run` obeys `command` at `now_us`, the robot's time. Counts the commands that are
  /// missing before an accepted one.
  [[nodiscard]] bool accepts(const joint_command_t& command, int64_t robot_run, int64_t now_us) {
    const bool other_robot = command.robot_run != robot_run;
    if (other_robot || !followed_.accepts(command.run, now_us)) {
      refusal_ = other_robot ? "refused commands for another robot" : "refused commands of another bridge";
      return false;
    }
    bridge_run_ = command.run;
    missing_ += gaps_.missing_before(command.sequence);
    return true;
  }

  /// Why the newest refused command was refused; "" before the first.
  const char* refusal() const { return refusal_; }
  /// Run of the bridge whose command was accepted last; 0 before the first.
  int64_t bridge_run() const { return bridge_run_; }
  /// Number of commands of the followed bridge that never arrived.
  int64_t missing() const { return missing_; }

 private:
  // Far longer than the robot's command time-out, after which it has stopped, and shorter than the start of a bridge:
  // a robot that ignored a new bridge's first commands would leap once it obeys.
  FollowedRun followed_{100000};
  SequenceGapCounter gaps_;
  const char* refusal_ = "";
  int64_t bridge_run_ = 0, missing_ = 0;
};

}  // namespace multireach
