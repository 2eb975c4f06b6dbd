#pragma once

#include <map>
#include <set>

#include "runtime/node.hpp"
#include "runtime/robot_config.hpp"

namespace multireach {

struct ViewOptions {
  std::set<std::string> wait_for;  ///< finish when each of these nodes has sent NODE_STATUS
  bool terminal = false;           ///< update one line in place; else print a new line every few seconds
  double speed = 1;                ///< seconds of its ticks per second
};

/// Prints a live status line on standard error: target, hand, their distance, message rates, and the states of
/// controller and bridge, so that a pause or a fault is seen, or for how long they were not heard.
class ViewNode : public Node {
 public:
  ViewNode(const RobotConfig& robot, ViewOptions options) : chain_(robot.chain), options_(std::move(options)) {}

  std::string name() const override { return "view"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> next_tick() const override { return next_tick_us_; }
  int64_t tick_period_us() const override { return kPeriodUs; }
  void tick(Outbox& out) override;
  bool finished() const override { return !options_.wait_for.empty() && missing().empty(); }
  std::string state() const override { return "watching"; }

  /// The awaited nodes that have not been heard from.
  std::set<std::string> missing() const;
  /// The current status line.
  std::string line() const;

 private:
  static constexpr int64_t kPeriodUs = 250000;
  static constexpr double kOldS = 3;  // of NODE_STATUS, which comes once a second

  /// What a node said of itself last.
  struct Heard {
    std::string state;
    int64_t at_us = 0;  // in time of the ticks
  };

  /// Its state, or for how long it was not heard.
  std::string state_of(const std::string& node) const;

  Chain chain_;
  ViewOptions options_;
  int64_t next_tick_us_ = 0;
  std::optional<Eigen::Vector3d> target_, hand_;
  bool target_seen_ = false;
  std::map<std::string, Heard> nodes_;
  std::map<std::string, int, std::less<>> received_;    // since the last line
  std::map<std::string, double, std::less<>> rate_hz_;  // smoothed
};

}  // namespace multireach
