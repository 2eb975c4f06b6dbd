// The plots that the user has chosen, fed with messages of one run or of two.
import type {Vector3} from 'three';
import {byName, type ControllerState, type JointFields, type JointSetpoint, type Message, type NodeStatus, type Setup, type Target} from './messages';
import {Plot, jointLegend} from './plots';

const kTitles = {
  positions: 'joint position', velocities: 'joint velocity', accelerations: 'joint acceleration', speed: 'hand speed', gamma: 'γ',
  condition: 'condition number', age: 'age of the target', lateness: 'lateness of ticks',
};
export type PlotName = keyof typeof kTitles;
const kNames = Object.keys(kTitles) as PlotName[];
const kDefault: PlotName[] = ['positions', 'velocities', 'speed', 'gamma'];
const kNodes = ['bridge', 'controller', 'robot_sim'];  // whose ticks matter
const kLongestStep = 0.5;  // s: a difference over more is no derivative
const kQuantile = 0.99;
const kFirstBin = 16e-3;  // ms; each bin of node_status_t ends at twice the one before

/** What derivatives need of a run's newest messages. */
interface Before { command?: JointFields; hand?: {point: Vector3; time: number}; targets: Map<number, number>; lateness: Map<string, number[]> }
const nothingBefore = (): Before => ({targets: new Map(), lateness: new Map()});

export class PlotPanel {
  private plots?: Record<PlotName, Plot>;
  private joints: Setup['joints'] = [];
  private readonly before = [nothingBefore(), nothingBefore()];
  private readonly chosen: Set<PlotName>;
  private readonly choices = new Map<PlotName, HTMLInputElement>();
  onChoice = () => {};

  constructor(private readonly parent: HTMLElement, menu: HTMLElement) {
    const kept = (localStorage.getItem('plots') ?? '').split(',').filter(name => kNames.includes(name as PlotName)) as PlotName[];
    this.chosen = new Set(kept.length ? kept : kDefault);
    for (const name of kNames) {
      const label = document.createElement('label'), box = document.createElement('input');
      box.type = 'checkbox';
      box.addEventListener('change', () => {
        this.choose(box.checked ? [...this.chosen, name] : [...this.chosen].filter(each => each !== name));
        localStorage.setItem('plots', this.names.join(','));
        this.onChoice();
      });
      label.append(box, ` ${kTitles[name]}`);
      menu.append(label);
      this.choices.set(name, box);
    }
  }

  get names(): PlotName[] { return kNames.filter(name => this.chosen.has(name)); }

  choose(names: string[]) {
    this.chosen.clear();
    for (const name of kNames) if (names.includes(name)) this.chosen.add(name);
    for (const name of kNames) {
      this.choices.get(name)!.checked = this.chosen.has(name);
      if (!this.plots) continue;
      this.plots[name].figure.hidden = !this.chosen.has(name);
      this.plots[name].dirty = true;
    }
  }

  setup(joints: Setup['joints'], legend: HTMLElement) {
    this.joints = joints;
    jointLegend(legend, joints);
    this.parent.replaceChildren();
    const limits = joints.flatMap(joint => [joint.lower, joint.upper]).filter((limit): limit is number => limit !== null);
    const unit = joints.some(joint => joint.type === 'prismatic') ? 'rad or m' : 'rad';
    const accelerations = joints.every(joint => joint.acceleration) ? '% of limit); dashed: ±100' : `${unit} / s²); no limits are given`;
    const plot = (title: string, series: number, levels: number[] = [], floor?: [number, number]) => new Plot(this.parent, title, series, levels, floor);
    this.plots = {
      positions: plot(`joint position (${unit}); dashed: limits`, joints.length, limits),
      velocities: plot('joint velocity (% of limit); dashed: ±100', joints.length, [-100, 100], [-100, 100]),
      accelerations: plot(`joint acceleration of commands (${accelerations}`, joints.length, joints.every(joint => joint.acceleration) ? [-100, 100] : [], [-10, 10]),
      speed: plot('hand speed (m/s)', 1, [], [0, 0.1]),
      gamma: plot('γ (rad²/m²)', 1, [], [0, 1]),
      condition: plot('condition number', 1, [], [0, 10]),
      age: plot('from image to set-point (ms)', 1, [], [0, 10]),
      lateness: plot(`99 % of ticks late by less (ms): ${kNodes.join(', ')}`, kNodes.length, [], [0, 0.1]),
    };
    this.before.splice(0, 2, nothingBefore(), nothingBefore());
    this.choose(this.names);
  }

  clear() {
    this.before.splice(0, 2, nothingBefore(), nothingBefore());
    for (const plot of Object.values(this.plots ?? {})) plot.clear();
  }

  /** `run`: 0, or 1 for the run that is compared with it. `hand`: its position, for a ROBOT_STATE. */
  add({channel, message}: Message, time: number, run: 0 | 1, hand?: Vector3) {
    if (!this.plots) return;
    const show = (name: PlotName, values: (number | null)[]) => run ? this.plots![name].addCompared(time, values) : this.plots![name].add(time, values);
    const before = this.before[run];
    if (channel === 'ROBOT_STATE') {
      const fields = message as JointFields, positions = byName(fields), velocities = byName(fields, fields.joint_velocity);
      show('positions', this.joints.map(joint => positions[joint.name] ?? null));
      show('velocities', this.joints.map(joint => joint.velocity ? 100 * velocities[joint.name] / joint.velocity : null));
      if (hand && before.hand && time > before.hand.time) show('speed', [hand.distanceTo(before.hand.point) / (time - before.hand.time)]);
      if (hand) before.hand = {point: hand, time};
    } else if (channel === 'CONTROLLER_STATE') {
      const {gamma_rad2_m2, condition_number} = message as ControllerState;
      show('gamma', [gamma_rad2_m2]);
      show('condition', [condition_number]);
    } else if (channel === 'JOINT_COMMAND') {
      const command = message as JointFields;
      const step = before.command ? 1e-6 * (command.utime - before.command.utime) : 0;
      if (before.command && step > 0 && step < kLongestStep) show('accelerations', this.accelerations(before.command, command, step));
      before.command = command;
    } else if (channel === 'TARGET') {
      const {sequence, utime} = message as Target;
      before.targets.set(sequence, utime);
      if (before.targets.size > 50) before.targets.delete(before.targets.keys().next().value!);
    } else if (channel === 'JOINT_SETPOINT') {
      const {utime, target_sequence} = message as JointSetpoint;
      const seen = before.targets.get(target_sequence);
      if (seen !== undefined) show('age', [1e-3 * (utime - seen)]);
    } else if (channel === 'NODE_STATUS') {
      const status = message as NodeStatus;
      const old = before.lateness.get(status.node);
      before.lateness.set(status.node, status.lateness);
      if (old && kNodes.includes(status.node)) show('lateness', kNodes.map(node => node === status.node ? latenessQuantile(old, status.lateness) : null));
    }
  }

  draw() { for (const plot of Object.values(this.plots ?? {})) plot.draw(); }
  setTheme(theme: {text: string; line: string}) { for (const plot of Object.values(this.plots ?? {})) plot.setTheme(theme); }

  private accelerations(from: JointFields, to: JointFields, step: number): (number | null)[] {
    const before = byName(from, from.joint_velocity), after = byName(to, to.joint_velocity);
    const limited = this.joints.every(joint => joint.acceleration);
    return this.joints.map(({name, acceleration}) => {
      const value = (after[name] - before[name]) / step;
      if (!Number.isFinite(value)) return null;
      return limited ? 100 * value / acceleration! : value;
    });
  }
}

/** The upper end, in milliseconds, of the bin that 99 % of the ticks since `before` reach; the last bin has none. */
function latenessQuantile(before: number[], now: number[]): number | null {
  const ticks = now.map((count, i) => count - before[i]);
  const all = ticks.reduce((sum, count) => sum + count, 0);
  if (!(all > 0)) return null;
  let sum = 0;
  for (let bin = 0; bin < ticks.length; ++bin) {
    sum += ticks[bin];
    if (sum >= kQuantile * all) return kFirstBin * 2 ** bin;
  }
  return null;
}
