#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "kinematics/joint_vector.hpp"

namespace multireach::drivers {

/// Follows one arm on an LCM channel whose messages do not say who sent them: a status of another arm, or one that
/// comes late, is refused and counted under its name, and the arm that was heard first goes on being followed.
class StatusFilter {
 public:
  /// `channel`: for the text. `joints`: of the arm.
  StatusFilter(std::string channel, int joints) : channel_(std::move(channel)), joints_(joints) {}

  /// Whether to use a status. `utime`: its time, microseconds, or -1 where it has none. `position`, `velocity`: what it
  /// measures. `now_us`: time of receipt.
  [[nodiscard]] bool accepts(int64_t utime, const JointVector& position, const JointVector& velocity, int64_t now_us);
  /// The arm is silent: the next status may be of any.
  void forget() { position_.reset(); }
  /// Whether only arms with another number of joints have been heard.
  bool only_others() const { return !position_ && other_size_ > 0; }

  int64_t refused() const { return invalid_ + other_size_ + other_arm_ + older_; }
  /// Number of refused messages by cause; "" for none.
  std::string text() const;

 private:
  std::string channel_;
  int joints_;
  int64_t utime_ = -1, heard_us_ = 0;
  int older_in_a_row_ = 0;
  std::optional<JointVector> position_;  // of the last one accepted
  int64_t invalid_ = 0, other_size_ = 0, other_arm_ = 0, older_ = 0;
};

}  // namespace multireach::drivers
