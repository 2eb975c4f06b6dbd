#pragma once

#include <array>
#include <span>
#include <string_view>

#include "runtime/channels.hpp"

namespace multireach {

/// A process of the loop and the channels that it publishes. The first counts its messages; the others carry the
/// sequence numbers of the first.
struct Publisher {
  std::string_view node;
  std::array<std::string_view, 2> channels;  ///< "" for none

  std::string_view main_channel() const { return channels[0]; }
};

/// In the order in which messages depend on one another. The robot is simulated (by physics or ideally) or real.
inline constexpr std::array kPublishers{Publisher{"vision", {channel::kTarget, channel::kTrackerState}},
                                        Publisher{"controller", {channel::kJointSetpoint, channel::kControllerState}},
                                        Publisher{"bridge", {channel::kJointCommand, channel::kBridgeState}},
                                        Publisher{"robot_sim", {channel::kRobotState, channel::kSimStep}},
                                        Publisher{"ideal_robot", {channel::kRobotState, ""}}};

/// The process that publishes on a channel; for ROBOT_STATE the simulated robot. "" for a channel that comes from
/// outside the loop.
constexpr std::string_view publisher_of(std::string_view channel) {
  for (const Publisher& publisher : kPublishers) {
    for (const std::string_view published : publisher.channels) {
      if (!published.empty() && published == channel) return publisher.node;
    }
  }
  return "";
}

}  // namespace multireach
