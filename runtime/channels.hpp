#pragma once

#include <array>
#include <string>
#include <string_view>

namespace multireach::channel {

inline constexpr std::string_view kStereoImages = "STEREO_IMAGES";
inline constexpr std::string_view kTargetTruth = "TARGET_TRUTH";
inline constexpr std::string_view kTarget = "TARGET";
inline constexpr std::string_view kObstacles = "OBSTACLES";
inline constexpr std::string_view kTargetChoice = "TARGET_CHOICE";
inline constexpr std::string_view kJointSetpoint = "JOINT_SETPOINT";
inline constexpr std::string_view kControllerState = "CONTROLLER_STATE";
inline constexpr std::string_view kJointCommand = "JOINT_COMMAND";
inline constexpr std::string_view kBridgeState = "BRIDGE_STATE";
inline constexpr std::string_view kBridgeRequest = "BRIDGE_REQUEST";
inline constexpr std::string_view kRobotState = "ROBOT_STATE";
inline constexpr std::string_view kSimStep = "SIM_STEP";
inline constexpr std::string_view kTrackerState = "TRACKER_STATE";
inline constexpr std::string_view kTargetCandidates = "TARGET_CANDIDATES";
inline constexpr std::string_view kPerturbation = "PERTURBATION";
inline constexpr std::string_view kPracticeScene = "PRACTICE_SCENE";
inline constexpr std::string_view kNodeInputs = "NODE_INPUTS";
inline constexpr std::string_view kReplayStep = "REPLAY_STEP";
inline constexpr std::string_view kReplayDone = "REPLAY_DONE";
inline constexpr std::string_view kNodeStatus = "NODE_STATUS";
inline constexpr std::string_view kVisionDebug = "VISION_DEBUG";
inline constexpr std::string_view kVisionDebugRequest = "VISION_DEBUG_REQUEST";

/// All of the above.
inline constexpr std::array kAll{kStereoImages,  kTargetTruth,       kTarget,       kObstacles,        kTargetChoice,
                                 kJointSetpoint, kControllerState,   kJointCommand, kBridgeState,      kBridgeRequest,
                                 kRobotState,    kSimStep,           kTrackerState, kTargetCandidates, kPerturbation,
                                 kPracticeScene, kNodeInputs,        kReplayStep,   kReplayDone,       kNodeStatus,
                                 kVisionDebug,   kVisionDebugRequest};

/// A process of the loop and the channels that it publishes, whose messages a replay computes again and compares. The
/// first channel counts the messages; the others carry the sequence numbers of the first.
struct Publisher {
  std::string_view node;
  std::array<std::string_view, 3> channels;  ///< "" for none

  std::string_view main_channel() const { return channels[0]; }
};

/// In the order in which messages depend on one another. The robot is simulated (by physics or ideally) or real.
inline constexpr std::array kPublishers{
    Publisher{"vision", {kTarget, kTrackerState, kTargetCandidates}},
    Publisher{"controller", {kJointSetpoint, kControllerState}}, Publisher{"bridge", {kJointCommand, kBridgeState}},
    Publisher{"robot_sim", {kRobotState, kSimStep}}, Publisher{"ideal_robot", {kRobotState}}};

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

/// Images have a UDP group of their own: every socket of a group receives all of its traffic, so images on the control
/// group would make the 1 kHz stream lose messages. TARGET_TRUTH is sent with the rendered image that it belongs to.
constexpr bool on_image_group(std::string_view channel) {
  return channel == kStereoImages || channel == kTargetTruth || channel == kVisionDebug;
}

/// Default URLs of the two groups (--lcm-url and --image-url): LCM's own default group, and the next one.
inline constexpr std::string_view kControlUrl = "udpm://239.255.76.67:7667?ttl=0";
inline constexpr std::string_view kImageUrl = "udpm://239.255.76.68:7668?ttl=0";

/// The URL of the images' group that belongs to a control group where none is given: kImageUrl for kControlUrl, else
/// the same group one port above. A URL that is not of a UDP group is returned as it is: one server carries both.
std::string image_url_for(std::string_view control_url);

}  // namespace multireach::channel
