import type {Vector3} from 'three';
import './style.css';
import {Connection} from './connection';
import {Course, type CourseStatus} from './course';
import {Candidates} from './candidates';
import {Controls, element, isTyping} from './controls';
import {byName, type BridgeState, type ControllerState, type Frame, type JointFields, type Message, type NodeStatus, type Obstacle, type RobotState, type Setup, type Target, type TargetCandidates, type TargetChoice} from './messages';
import {Nodes} from './nodes';
import {Pictures} from './pictures';
import {LogMode} from './log_mode';
import {PlotPanel} from './plot_panel';
import {Scene, type PointOfView} from './scene';
import {Touch} from './touch';
import {word} from './words';

const kPlotPeriod = 100;  // ms
const kSigmas = ['x', 'y', 'z'];

const scene = new Scene(element<HTMLCanvasElement>('scene'));
const pictures = new Pictures(element<HTMLCanvasElement>('picture'));
const nodes = new Nodes(element('nodes'));
const controls = new Controls(request => connection.send(request));
const touch = new Touch(scene, request => connection.send(request));
const course = new Course(scene, request => connection.send(request));
const candidates = new Candidates(scene);
const ghost = element<HTMLSelectElement>('ghost');
const contours = element<HTMLInputElement>('contours'), contoursWait = element('contours-wait');
const limits = element<HTMLInputElement>('limits');

const plots = new PlotPanel(element('plots'), element('plot-choice'));

let log: LogMode | undefined;  // when the page shows a log
let hand: Vector3 | undefined;
let robotHeard: number | undefined;  // ms, when the last ROBOT_STATE of a running system came
const kRobotSilent = 1000;  // ms
let newestTarget: Target | undefined, controller: ControllerState | undefined;

function setup(description: Setup) {
  element('robot-name').textContent = `· ${description.robot}`;
  plots.setup(description.joints, element('joints'));
  scene.setup(description);
  touch.setup(description.reach_m, description.tip);
  course.setup(description.reach_m);
  candidates.setup(description);
  hand = undefined;
  applyTheme();
  if (description.log !== undefined && !log) log = new LogMode(description.log, {connection, scene, pictures, plots, contours, show: frame => waiting.push(frame)});
}

function showReach() {
  const parts: string[] = [];
  const silence = !log && robotHeard !== undefined ? performance.now() - robotHeard : 0, silent = silence > kRobotSilent;
  if (silent) parts.push(`no ROBOT_STATE for ${(silence / 1000).toFixed(0)} s: the arm is drawn where it was last`);
  if (newestTarget) {
    const {name, status, reason, position_m, covariance_m2} = newestTarget;
    const frame = status === 3 ? ' in the left camera\'s frame' : '';
    const where = status === 0 || status === 4 ? '' : ` at ${position_m.map(value => value.toFixed(3)).join(', ')} m${frame}`;
    const sigma = kSigmas.map((_, i) => (1e3 * Math.sqrt(Math.max(covariance_m2[i][i], 0))).toFixed(1)).join(', ');
    parts.push(`${name === 'target' ? name : `target ${name}`}: ${word('target', status)}${where}${status === 1 ? `, σ ${sigma} mm` : ` – ${reason}`}`);
    if (hand && !silent && (status === 1 || status === 2)) {
      const distance = Math.hypot(position_m[0] - hand.x, position_m[1] - hand.y, position_m[2] - hand.z);
      parts.push(`hand ${(1e3 * distance).toFixed(1)} mm away`);
    }
  }
  if (controller) {
    const why = controller.target_unreachable ? ' (out of reach)' : controller.blocked ? ` (blocked: ${word('blocked', controller.blocked)})` : controller.target_lost ? ' (target lost)' : '';
    parts.push(`controller: ${word('mode', controller.mode)}${why}`);
  }
  const clearance = scene.clearance();
  if (clearance) {
    const millimetres = 1e3 * clearance.distance;
    parts.push(millimetres > 0 ? `clearance ${millimetres.toFixed(1)} mm to obstacle ${clearance.obstacle + 1}` : `touches obstacle ${clearance.obstacle + 1}`);
  }
  if (!silent) parts.push(...scene.nearLimits());
  const text = parts.join(' · ') || 'no target';
  const line = element('reach');
  if (line.textContent !== text) line.textContent = text;
}

function showGhost({channel, message}: Message) {
  if (channel !== ghost.value) return;
  const fields = message as JointFields & Partial<ControllerState>;
  scene.setGhost(byName(fields, channel === 'CONTROLLER_STATE' ? fields.target_joint_position : fields.joint_position));
}

const handlers: Record<string, (message: never, at?: number) => void> = {
  TARGET: (target: Target) => {
    touch.target(target);
    if (touch.follows(target.name)) {
      newestTarget = target;
      candidates.target(target);
    }
    scene.setTarget(target, target.status === 1 || target.status === 2, target.status === 1);
  },
  TARGET_CANDIDATES: (several: TargetCandidates) => { if (touch.follows(several.name)) candidates.show(several); },
  CONTROLLER_STATE: (state: ControllerState) => { controller = state; },
  ROBOT_STATE: (state: RobotState) => {
    robotHeard = performance.now();
    touch.robot(state.simulated);
  },
  TARGET_CHOICE: (choice: TargetChoice) => touch.choose(choice),
  OBSTACLES: ({obstacles}: {obstacles: Obstacle[]}) => {
    scene.setObstacles(obstacles);
    touch.known(obstacles);
  },
  BRIDGE_STATE: (state: BridgeState) => controls.show(state),
  NODE_STATUS: (status: NodeStatus, at?: number) => nodes.show(status, at === undefined ? undefined : 1e-3 * at),
};

function showFrame({messages, compared, history, begins}: Frame) {
  if (begins) {
    plots.clear();
    scene.clearTrails();
    candidates.clear();
    if (log && !compared) {  // what comes later in the log is not known yet
      newestTarget = controller = undefined;
      controls.badge('', 'no BRIDGE_STATE yet');
    }
  }
  for (const each of messages) {
    const time = 1e-6 * (each.at ?? (each.message as {utime: number}).utime);
    let point: Vector3 | undefined;
    if (each.channel === 'ROBOT_STATE') {
      const positions = byName(each.message as RobotState), trailed = history !== 'none';
      if (compared) point = scene.setCompared(positions, trailed);
      else hand = point = scene.setMeasured(positions, trailed);
    }
    if (history !== 'none') plots.add(each, time, compared ? 1 : 0, point);
    if (history === 'only' || compared) continue;
    handlers[each.channel]?.(each.message as never, each.at);
    showGhost(each);
  }
}

/** The newest frames, drawn at the next animation frame of the browser. */
const waiting: Frame[] = [];
const kMostWaiting = 50;  // while the tab is hidden, nothing is drawn

// Script per drawn frame, for the line at the bottom and for tests.
const spent = {frames: 0, script: 0, since: performance.now()};

function draw(now: number) {
  requestAnimationFrame(draw);
  const begin = performance.now();
  for (const frame of waiting.splice(0)) showFrame(frame);
  const drawn = scene.render();
  if (now - lastPlots > kPlotPeriod) {
    lastPlots = now;
    nodes.refresh(log?.nowMs);
    showReach();
    candidates.refresh(newestTarget?.status === 3);
    plots.draw();
  }
  if (!drawn) return;
  ++spent.frames;
  spent.script += performance.now() - begin;
}
let lastPlots = 0;

function showPerformance() {
  const seconds = (performance.now() - spent.since) / 1000;
  const perFrame = spent.frames ? (spent.script + connection.takeDecoding()) / spent.frames : 0;
  const rate = spent.frames / seconds;
  Object.assign(document.documentElement.dataset, {framesPerS: rate.toFixed(1), scriptMs: perFrame.toFixed(2)});
  element('performance').textContent = spent.frames ? `${rate.toFixed(0)} frames/s, ${perFrame.toFixed(1)} ms of script each` : '';
  Object.assign(spent, {frames: 0, script: 0, since: performance.now()});
}

function showRates(rates: Record<string, number>) {
  const text = Object.entries(rates).map(([channel, rate]) => `${channel.toLowerCase().replaceAll('_', ' ')} ${rate}`).join(' · ');
  const line = element('rates');
  const words = text ? `a second: ${text}` : '';
  if (line.textContent !== words) line.textContent = line.title = words;
}

const connection = new Connection({
  setup,
  frame: frame => {
    showRates(frame.rates ?? {});
    if (frame.course) course.show(frame.course as CourseStatus);
    contoursWait.hidden = !frame.vision_late;
    waiting.push(frame);
    if (waiting.length > kMostWaiting) waiting.shift();
  },
  answer: answer => {
    if (answer.client && answer.client !== touch.client) return;
    // An accepted step shows itself in the set-up's own lines.
    if (answer.answer !== 'course') controls.answer(answer);
    log?.answer(answer);
    touch.answer(answer);
    course.answer(answer);
  },
  picture: picture => void pictures.show(picture),
  runs: runs => log?.showRuns(runs),
  connected: problem => {
    if (problem) {
      controls.badge('gone', problem);
    } else {
      controls.badge('', 'waiting for the bridge');
      connection.send({contours: contours.checked});
    }
  },
});

function applyTheme() {
  const root = document.documentElement;
  root.dataset.theme ??= matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
  const style = getComputedStyle(root);
  const of = (name: string) => style.getPropertyValue(name).trim();
  scene.setTheme(of('--panel'));
  plots.setTheme({text: of('--quiet'), line: of('--line')});
  log?.draw();
}

function changeTheme() {
  document.documentElement.dataset.theme = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
  localStorage.setItem('theme', document.documentElement.dataset.theme);
  applyTheme();
}

const views = [...document.querySelectorAll<HTMLButtonElement>('[data-view]')];
for (const button of views) button.addEventListener('click', () => scene.look(button.dataset.view as PointOfView));
element('theme').addEventListener('click', changeTheme);
ghost.addEventListener('change', () => { if (!ghost.value) scene.setGhost(); });
limits.addEventListener('change', () => { scene.limitsShown = limits.checked; });
contours.addEventListener('change', () => connection.send({contours: contours.checked}));
const menu = document.querySelector<HTMLDetailsElement>('.menu')!;
menu.addEventListener('keydown', event => {
  if (event.key !== 'Escape' || !menu.open) return;
  menu.open = false;
  menu.querySelector('summary')!.focus();
});
addEventListener('pointerdown', event => { if (!menu.contains(event.target as Node)) menu.open = false; });
addEventListener('keydown', event => {
  if (event.ctrlKey || event.altKey || event.metaKey || isTyping(event)) return;
  if (event.key.toLowerCase() === 't') changeTheme();
  views[Number(event.key) - 1]?.click();
});

Object.assign(window, {sampledClearance: () => scene.sampledClearance()});  // for tests

const kept = localStorage.getItem('theme');
if (kept) document.documentElement.dataset.theme = kept;
applyTheme();
setInterval(showPerformance, 1000);
requestAnimationFrame(draw);
