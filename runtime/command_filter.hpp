#pragma once

#include <multireach/joint_command_t.hpp>

#include "runtime/followed_run.hpp"
#include "runtime/node.hpp"

namespace multireach {

/// Which commands a robot obeys: those that name the robot's own run, of one bridge at a time, each newer than the one
/// before: an old one would take the robot back and forth again within a millisecond.
class CommandFilter {
 public:
  /// Why the robot of run `robot_run` refuses `command` at `now_us`, the robot's time; null when it may obey.
  [[nodiscard]] const char* refusal_of(const joint_command_t& command, int64_t robot_run, int64_t now_us) {
    const char* refusal = nullptr;
    if (command.robot_run != robot_run) refusal = "refused commands for another robot";
    if (!refusal && !followed_.would_accept(command.run, now_us)) refusal = "refused commands of another bridge";
    if (!refusal && command.run == bridge_run_ && command.sequence <= sequence_)
      refusal = "refused commands that came late or twice";
    if (!refusal) missing_ += gaps_.newly_lost(command.sequence, command.run);
    return refusal;
  }
  /// The robot obeys this command, and from now on its bridge. A bridge whose commands are refused owns nothing.
  void obey(const joint_command_t& command, int64_t now_us) {
    followed_.follow(command.run, now_us);
    bridge_run_ = command.run;
    sequence_ = command.sequence;
  }

  /// Run of the bridge that was obeyed last; 0 before the first command.
  int64_t bridge_run() const { return bridge_run_; }
  /// Sequence number of the command that was obeyed last; -1 before the first.
  int64_t sequence() const { return sequence_; }
  /// Number of commands that never arrived.
  int64_t missing() const { return missing_; }

 private:
  // Far longer than the robot's command time-out, after which it has stopped, and shorter than the start of a bridge:
  // a robot that ignored a new bridge's first commands would leap once it obeys.
  FollowedRun followed_{100000};
  SequenceGapCounter gaps_;
  int64_t bridge_run_ = 0, sequence_ = -1, missing_ = 0;
};

}  // namespace multireach
