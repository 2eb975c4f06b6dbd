#pragma once

#include "tools/foxglove/scene.hpp"
#include "tools/page/foxglove_hub.hpp"

namespace multireach {

/// Sends the messages of a running system to Foxglove's clients, as multireach-log export mcap writes them: each
/// channel as JSON, images, and what the 3-D view draws. Only what a client has subscribed to is converted.
class FoxgloveFeed {
 public:
  FoxgloveFeed(FoxgloveHub& hub, const RobotConfig& robot, const StereoRig* rig) : hub_(hub), scene_(robot, rig) {}

  /// `utime`: now, by the wall clock, microseconds.
  void receive(std::string_view channel, std::span<const uint8_t> bytes, int64_t utime);

 private:
  void send(const FoxgloveMessage& message, int64_t utime);

  FoxgloveHub& hub_;
  FoxgloveScene scene_;
};

}  // namespace multireach
