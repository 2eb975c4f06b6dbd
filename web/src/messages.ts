// What the page receives. The fields of messages are those of lcmtypes/.

export interface Joint { name: string; type: string; lower: number | null; upper: number | null; velocity: number | null; acceleration: number | null }
export interface Camera { name: string; width_px: number; height_px: number; fx_px: number; fy_px: number; cx_px: number; cy_px: number; X_WC: number[] }
export interface Setup {
  robot: string; build: string; urdf: string; base: string; tip: string; reach_m: number; link_radius_m: number; joints: Joint[]; cameras: Camera[];
  log?: string;  // name of the log that is shown; nothing for a running system
}

export interface JointFields { utime: number; joint_name: string[]; joint_position: number[]; joint_velocity?: number[] }
export interface JointSetpoint extends JointFields { target_sequence: number }
export interface RobotState extends JointFields { simulated: boolean; fault: string }
export interface ControllerState extends JointFields {
  hand_position_m: number[]; condition_number: number; mode: number; target_lost: boolean; target_unreachable: boolean; blocked: number; distance_m: number; gamma_rad2_m2: number;
  target_joint_position: number[];
}
export interface Target {
  sequence: number; utime: number; status: number; name: string; reason: string; position_m: number[]; velocity_m_s: number[]; covariance_m2: number[][];
}
/** Scores are natural logarithms of likelihood ratios, up to constants that all candidates of a message have in common. */
export interface TargetCandidate {
  position_m: number[]; left_px: number[]; right_px: number[]; chosen: boolean; reason: string;
  score: number; still_score: number; round_score: number; colour_score: number; stereo_score: number; size_score: number; history_score: number;
}
export interface TargetCandidates { utime: number; sequence: number; name: string; candidates: TargetCandidate[] }
export interface TargetChoice { kind: number; name: string; chosen_by: string }
export interface Obstacle { name: string; shape: number; position_m: number[]; orientation_wxyz: number[]; size_m: number[] }
export interface BridgeState { state: number; cause: string; path_rate: number; setpoint_rate: number; speed: number; request_accepted: boolean }
export interface NodeStatus {
  node: string; state: string; build_id: string; lateness: number[]; received: number; dropped: number; refused: number; late: number; limited: number; sent: number;
}

/** `at`: time in the log that is shown, microseconds; nothing live. */
export interface Message { channel: string; message: unknown; at?: number }
export interface Frame {
  utime: number; messages: Message[]; rates?: Record<string, number>;
  compared?: boolean;  // of the run that is shown over the first one
  history?: 'only' | 'none';  // whether plots and trails get the messages; live they do
  begins?: boolean;  // plots and trails begin anew
  course?: unknown;  // the state of the set-up
  vision_late?: boolean;  // vision is behind the images, and not asked for contours
}

/** A run of a log: itself, another log, or what a replay computes from it. */
export interface Run {
  id: number; label: string; set: string[]; robot_model: string; state: 'waiting' | 'computing' | 'ready' | 'failed'; doing: string;
  progress: number; failure: string; comparison: Comparison | null; figures: Record<string, number | boolean | string | null> | null;
}
export interface Comparison {
  compared: number; hand_distance_m: number; hand_at_us: number;
  first: {channel: string; name: string; utime: number; at_us: number; field: string; values: [string, string]} | null;
}
/** `client`: the browser that asked, where not all are meant. */
export interface Answer { answer: string; accepted: boolean; text: string; client?: string }
export type Picture = {side: 'left' | 'right' | 'pair'; jpeg: Blob};

/** The joint positions of a message by joint name. */
export function byName(message: JointFields, values: number[] = message.joint_position): Record<string, number> {
  return Object.fromEntries(message.joint_name.map((name, i) => [name, values[i]]));
}
