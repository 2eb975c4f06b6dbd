#pragma once

#include "runtime/channels.hpp"

namespace multireach::channel {

/// What a channel carries: its type of message, when messages are sent, and which programs send them and act on them
/// (names without "multireach-"; "yours": a program of the user's). docs/messages.md shows these rows; tests compare
/// them with the nodes.
struct Channel {
  std::string_view name, type, sent, senders, receivers;
};

/// In the order of kAll.
inline constexpr std::array kChannels{
    Channel{kStereoImages, "images_t", "each stereo pair, 30 Hz", "camera, publish, replay", "vision, page"},
    Channel{kTargetTruth, "target_t", "with each rendered pair", "camera, publish", "page"},
    Channel{kTarget, "target_t", "each stereo pair, one for each target", "vision, publish, page, yours",
            "controller, view, page"},
    Channel{kObstacles, "obstacles_t", "at any time", "publish, page, yours", "controller, page"},
    Channel{kTargetChoice, "target_choice_t", "1 Hz while somebody has chosen a target", "page", "controller, page"},
    Channel{kJointSetpoint, "joint_setpoint_t", "20 Hz, and at each target", "controller, page", "bridge, view, page"},
    Channel{kControllerState, "controller_state_t", "with each JOINT_SETPOINT", "controller", "robot, page"},
    Channel{kJointCommand, "joint_command_t", "1 kHz", "bridge", "robot-sim, robot-driver, view, page"},
    Channel{kBridgeState, "bridge_state_t", "20 Hz, and as answer to a request", "bridge", "controller, robot, page"},
    Channel{kBridgeRequest, "bridge_request_t", "when a user asks", "robot, page", "bridge, robot-driver"},
    Channel{kRobotState, "robot_state_t", "state_hz, 200 Hz", "robot-sim, robot-driver, replay, yours",
            "bridge, controller, camera, robot, view, page"},
    Channel{kSimStep, "sim_step_t", "after each ROBOT_STATE", "robot-sim", ""},
    Channel{kTrackerState, "tracker_state_t", "after each TARGET", "vision", ""},
    Channel{kTargetCandidates, "target_candidates_t", "after a TARGET with several candidates, or none chosen",
            "vision", ""},
    Channel{kPerturbation, "perturbation_t", "at any time", "publish, page, yours", "robot-sim, robot-emulator"},
    Channel{kPracticeScene, "practice_scene_t", "when it changes, in a practice", "page", "camera"},
    Channel{kNodeInputs, "node_inputs_t", "before the messages that depend on it", "vision, controller, bridge", ""},
    Channel{kReplayStep, "replay_step_t", "each step of a replay in lockstep", "replay",
            "vision, controller, bridge, robot-sim"},
    Channel{kReplayDone, "replay_done_t", "each step of a replay in lockstep", "vision, controller, bridge, robot-sim",
            "replay"},
    Channel{kNodeStatus, "node_status_t", "1 Hz", "every node", "robot, view, page"},
    Channel{kVisionDebug, "images_t", "each stereo pair, for two seconds after a request", "vision", "view, page"},
    Channel{kVisionDebugRequest, "debug_request_t", "1 Hz while the picture is shown", "view, page", "vision"}};

}  // namespace multireach::channel
