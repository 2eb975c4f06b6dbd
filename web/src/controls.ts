// Buttons and keys of the robot's state.
import type {Answer, BridgeState} from './messages';
import {word} from './words';

const kButtons = ['stop', 'enable', 'disable', 'pause', 'resume', 'reset'] as const;
const kKeys: Record<string, string> = {e: 'enable', d: 'disable', p: 'pause', c: 'resume', r: 'reset'};
const kSymbols: Record<string, string> = {idle: '○', armed: '◇', running: '▶', paused: 'Ⅱ', stopping: '▼', fault: '⚠', gone: '✕'};
const kUntouched = 1500;  // ms: so long after the user moved the slider the bridge's value is shown again

export const element = <Type extends HTMLElement>(id: string) => document.getElementById(id) as Type;

/** Whether the page shows a log: then there is no robot to command. */
export const showsLog = () => document.body.dataset.mode === 'log';
/** Whether a key belongs to the element that has the focus: a number that is typed, a choice in a list. */
export function isTyping({target}: KeyboardEvent): boolean {
  return target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && ['number', 'text'].includes(target.type));
}

export class Controls {
  private readonly slider = element<HTMLInputElement>('speed');
  private touched = -kUntouched;
  private state = '';

  constructor(private readonly send: (request: object) => boolean) {
    for (const id of kButtons) element(id).addEventListener('click', () => this.ask({request: id}));
    this.slider.addEventListener('input', () => this.showSpeed(Number(this.slider.value) / 100, true));
    this.slider.addEventListener('change', () => this.ask({request: 'speed', speed: Number(this.slider.value) / 100}));
    // Before any element sees it, also where the focus is on a button or the slider: space only ever stops.
    for (const type of ['keydown', 'keyup'] as const) addEventListener(type, event => this.space(event), {capture: true});
    addEventListener('keydown', event => this.key(event));
  }

  private ask(request: {request: string; speed?: number}) {
    if (this.send(request)) return;
    this.answer({answer: request.request, accepted: false, text: 'not sent: there is no connection'});
  }

  private space(event: KeyboardEvent) {
    if (event.code !== 'Space' || showsLog()) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (event.type === 'keydown' && !event.repeat) this.ask({request: 'stop'});
  }

  private key(event: KeyboardEvent) {
    if (showsLog() || event.ctrlKey || event.altKey || event.metaKey || event.repeat || isTyping(event)) return;
    const request = kKeys[event.key.toLowerCase()];
    if (request) this.ask({request});
  }

  private showSpeed(speed: number, byUser: boolean) {
    if (byUser) this.touched = performance.now();
    else if (performance.now() - this.touched < kUntouched) return;
    else this.slider.value = String(Math.round(100 * speed));
    element<HTMLOutputElement>('speed-value').value = `${Math.round(100 * speed)} %`;
  }

  answer(answer: Answer) {
    const line = element('answer');
    line.dataset.accepted = String(answer.accepted);
    line.textContent = `${answer.answer}: ${answer.accepted ? 'done' : 'refused'} – ${answer.text}`;
  }

  show(state: BridgeState) {
    const name = word('bridge', state.state);
    // A paused bridge keeps its state.
    const paused = state.cause !== '' && (name === 'running' || name === 'armed');
    // What was answered before a fault would contradict it.
    if (name === 'fault' && this.state !== 'fault' && !showsLog()) {
      const line = element('answer');
      line.dataset.accepted = 'true';
      line.textContent = 'Nothing moves in a fault. Reset leaves it, once the robot stands still.';
    }
    this.state = name;
    const slow = state.speed < 0.995 ? `, at ${Math.round(100 * state.speed)} %` : '';
    this.badge(paused ? 'paused' : name, name + (paused ? '' : slow) + (state.cause ? `: ${state.cause}` : ''));
    this.showSpeed(state.speed, false);
  }

  badge(state: string, text: string) {
    const badge = element('bridge');
    if (badge.dataset.state !== state) badge.dataset.state = state;
    const words = element('bridge-state');
    if (words.textContent !== text) words.textContent = text;
    element('bridge-symbol').textContent = kSymbols[state] ?? '?';
  }
}
