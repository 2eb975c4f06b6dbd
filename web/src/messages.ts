// What the page receives. The fields of messages are those of lcmtypes/.

export interface Joint { name: string; type: string; lower: number | null; upper: number | null; velocity: number | null; acceleration: number | null }
export interface Camera { name: string; width_px: number; height_px: number; fx_px: number; fy_px: number; cx_px: number; cy_px: number; X_WC: number[] }
export interface Setup {
  robot: string; build: string; urdf: string; base: string; tip: string; reach_m: number; link_radius_m: number; joints: Joint[]; cameras: Camera[];
}

export interface JointFields { utime: number; joint_name: string[]; joint_position: number[]; joint_velocity?: number[] }
export interface RobotState extends JointFields { simulated: boolean; fault: string }
export interface ControllerState extends JointFields {
  mode: number; target_lost: boolean; target_unreachable: boolean; blocked: number; distance_m: number; gamma_rad2_m2: number;
  target_joint_position: number[];
}
export interface Target {
  utime: number; status: number; name: string; reason: string; position_m: number[]; velocity_m_s: number[]; covariance_m2: number[][];
}
export interface Obstacle { name: string; shape: number; position_m: number[]; orientation_wxyz: number[]; size_m: number[] }
export interface BridgeState { state: number; cause: string; path_rate: number; setpoint_rate: number; speed: number; request_accepted: boolean }
export interface NodeStatus {
  node: string; state: string; build_id: string; received: number; dropped: number; refused: number; late: number; limited: number; sent: number;
}

export interface Message { channel: string; message: unknown }
export interface Frame { utime: number; messages: Message[]; rates: Record<string, number> }
export interface Answer { answer: string; accepted: boolean; text: string }
export type Picture = {side: 'left' | 'right' | 'pair'; jpeg: Blob};

/** The joint positions of a message by joint name. */
export function byName(message: JointFields, values: number[] = message.joint_position): Record<string, number> {
  return Object.fromEntries(message.joint_name.map((name, i) => [name, values[i]]));
}
