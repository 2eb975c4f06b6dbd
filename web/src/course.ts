// The guided set-up: steps from two cameras to an arm that reaches.
import * as THREE from 'three';
import type {Answer} from './messages';
import {element} from './controls';
import type {Scene} from './scene';

interface Step { name: string; done: boolean; text: string }
export interface CourseStatus {
  practice: boolean; folder: string; robot: string; current: string; begun: boolean; open: string; steps: Step[]; square_m: number; radius_m: number;
  details: {
    rate?: number; skew_ms?: number; picture?: string; learned?: boolean[]; pictures?: number; needed?: number; columns?: number; rows?: number; pattern?: string;
    result?: string; positions?: number[][]; points?: {held_m: number[]; seen_m: number[]; mm: number}[]; errors_mm?: number[]; seen_mm?: number[];
    sides?: {width?: number; height?: number; mean?: number; clipped?: number; sharpness?: number; fields?: number[]; corners?: number[][]}[];
  };
}

const kWords: Record<string, string> = {cameras: 'Cameras', board: 'Chessboard', object: 'Object', pose: 'Camera pose', check: 'Check', reach: 'Reach'};
const kSides = ['left', 'right'] as const;
const kHeld = 0x0072b2, kSeen = 0xd55e00;

function cell(row: HTMLTableRowElement, text: string, header = false) {
  const made = document.createElement(header ? 'th' : 'td');
  if (header) (made as HTMLTableCellElement).scope = 'col';
  made.textContent = text;
  row.append(made);
}

function table(head: string[], rows: string[][]): HTMLTableElement {
  const made = document.createElement('table');
  const top = made.createTHead().insertRow(), body = made.createTBody();
  for (const text of head) cell(top, text, true);
  for (const texts of rows) {
    const row = body.insertRow();
    for (const text of texts) cell(row, text);
  }
  return made;
}

export class Course {
  private status?: CourseStatus;
  private readonly panel = element('course');
  private readonly map = element<HTMLCanvasElement>('course-map');
  private readonly marks = new THREE.Group();
  private drawn = '';
  private shownSteps = '';
  private opened = false;
  private reach = 1;

  constructor(private readonly scene: Scene, private readonly send: (request: object) => boolean) {
    scene.overlay.add(this.marks);
    element('course-begin').addEventListener('click', () => this.begin());
    element('course-again').addEventListener('click', () => this.ask('again', this.current()));
    element('course-leave').addEventListener('click', () => this.ask('leave', this.current()));
    element('course-next').addEventListener('click', () => this.next());
    element('course-toggle').addEventListener('click', () => this.open(this.panel.hidden));
    const picture = element('picture');
    picture.addEventListener('click', event => this.click(event));
    // By keyboard: the middle of each image.
    picture.addEventListener('keydown', event => {
      const side = {l: 'left', r: 'right'}[event.key.toLowerCase()];
      if (side && this.clickable()) this.ask('act', 'object', {side, u: 0.5, v: 0.5});
    });
  }

  setup(reach: number) { this.reach = reach; }

  show(status: CourseStatus) {
    this.status = status;
    element('course-toggle').hidden = false;
    if (!this.opened) {
      this.opened = true;
      this.open(status.steps.some(step => !step.done));
    }
    const current = status.steps.find(step => step.name === status.current)!;
    Object.assign(this.panel.dataset, {step: status.current, begun: String(status.begun), done: String(current.done), complete: String(status.steps.every(step => step.done))});
    this.steps(status);
    const robot = element('course-robot');
    if (robot.textContent !== status.robot) robot.textContent = status.robot;
    const text = element('course-text');
    if (text.textContent !== current.text) text.textContent = current.text;
    text.dataset.done = String(current.done);
    element('course-begin').hidden = status.current === 'cameras' || (status.begun && status.current !== 'reach');
    element('course-leave').hidden = !status.begun || status.current === 'cameras' || current.done;
    element('course-again').hidden = !current.done || ['cameras', 'reach'].includes(status.current);
    const next = element('course-next');
    next.hidden = !current.done || this.following() === undefined;
    for (const form of this.panel.querySelectorAll<HTMLElement>('[data-form]')) form.hidden = form.dataset.form !== status.current || status.begun;
    this.fill('course-square', 1e3 * status.square_m);
    this.fill('course-radius', 1e3 * status.radius_m);
    this.details(status);
  }

  answer(answer: Answer) {
    if (answer.answer === 'course') element('course-problem').textContent = answer.accepted ? '' : answer.text;
  }

  private current() { return this.status?.current ?? 'cameras'; }
  private clickable() { return this.status?.current === 'object' && this.status.begun; }

  private following(): string | undefined {
    const names = this.status?.steps.map(step => step.name) ?? [];
    return names[names.indexOf(this.current()) + 1];
  }

  private open(open: boolean) {
    this.panel.hidden = !open;
    document.documentElement.dataset.course = String(open);
    element('course-toggle').setAttribute('aria-pressed', String(open));
  }

  private fill(id: string, value: number) {
    const input = element<HTMLInputElement>(id);
    if (document.activeElement !== input && input.dataset.touched !== 'true') input.value = String(Math.round(1e3 * value) / 1e3);
  }

  private ask(what: string, step: string, more: object = {}) { this.send({request: 'course', do: what, step, ...more}); }

  private begin() {
    const step = this.current();
    const number = (id: string) => Number(element<HTMLInputElement>(id).value);
    const more: Record<string, unknown> = {};
    if (step === 'board') more.square_m = number('course-square') / 1e3;
    if (step === 'object') more.radius_m = number('course-radius') / 1e3;
    const offset = element<HTMLInputElement>('course-offset').value.trim();
    if (step === 'pose' && offset) more.offset_m = offset.split(/[ ,;]+/).map(Number);
    this.ask('begin', step, more);
  }

  private next() {
    const following = this.following();
    if (following) this.ask('show', following);
  }

  private click(event: MouseEvent) {
    if (!this.clickable()) return;
    const {left, top, width, height} = element('picture').getBoundingClientRect();
    const across = 2 * (event.clientX - left) / width;
    this.ask('act', 'object', {side: across < 1 ? 'left' : 'right', u: across % 1, v: (event.clientY - top) / height});
  }

  private steps(status: CourseStatus) {
    const text = JSON.stringify([status.current, status.steps.map(step => step.done), status.open]);
    if (text === this.shownSteps) return;
    this.shownSteps = text;
    const list = element('course-steps');
    const openAt = status.steps.findIndex(step => step.name === status.open);
    list.replaceChildren(...status.steps.map(({name, done}, i) => {
      const item = document.createElement('li'), button = document.createElement('button');
      button.type = 'button';
      button.textContent = `${done ? '✓' : i + 1} ${kWords[name] ?? name}`;
      button.disabled = i > openAt;
      if (name === status.current) button.setAttribute('aria-current', 'step');
      button.addEventListener('click', () => this.ask('show', name));
      item.append(button);
      return item;
    }));
    element('course-folder').textContent = `${status.practice ? 'practice · ' : ''}${status.folder}`;
  }

  private details({current, details}: CourseStatus) {
    const text = JSON.stringify([current, details]);
    if (text === this.drawn) return;
    this.drawn = text;
    this.map.hidden = current !== 'board';
    const image = element<HTMLImageElement>('course-picture');
    image.hidden = !details.picture;
    if (details.picture && image.src !== details.picture) image.src = details.picture;
    const box = element('course-details');
    box.replaceChildren();
    this.marks.clear();
    if (current === 'cameras' && details.sides) {
      box.append(table(['', 'size (px)', 'brightness', 'white', 'sharpness'], details.sides.map((side, i) =>
        [kSides[i], `${side.width} × ${side.height}`, String(side.mean), `${(100 * (side.clipped ?? 0)).toFixed(1)} %`, String(side.sharpness)])));
      const line = document.createElement('p');
      line.textContent = `${details.rate} pairs a second, ${details.skew_ms?.toFixed(1)} ms apart`;
      box.append(line);
    }
    if (current === 'board') this.drawMap(details);
    if (current === 'check' && details.points?.length) {
      box.append(table(['x', 'y', 'z (m)', 'apart (mm)'], details.points.map(({held_m, mm}) => [...held_m.map(value => value.toFixed(3)), mm.toFixed(1)])));
    }
    if (current === 'reach' && details.errors_mm?.length) {
      const places = details.errors_mm.map((error, i) => [String(i + 1), error.toFixed(1), details.seen_mm![i].toFixed(1)]);
      box.append(table(['position', `from the object${this.status!.practice ? '\'s true position' : ''} (mm)`, 'from where it is seen (mm)'], places));
    }
    for (const {held_m, seen_m} of details.points ?? []) this.mark(held_m, seen_m);
    for (const hand of details.positions ?? []) this.mark(hand);
    this.scene.redraw();
  }

  /** In the 3-D view: where the hand had the object, and where it was seen. */
  private mark(held: number[], seen?: number[]) {
    const dot = (at: number[], colour: number) => {
      const mesh = new THREE.Mesh(new THREE.SphereGeometry(0.012 * this.reach, 10, 8), new THREE.MeshBasicMaterial({color: colour}));
      mesh.position.fromArray(at);
      this.marks.add(mesh);
    };
    dot(held, kHeld);
    if (!seen) return;
    dot(seen, kSeen);
    const ends = [held, seen].map(at => new THREE.Vector3().fromArray(at));
    this.marks.add(new THREE.Line(new THREE.BufferGeometry().setFromPoints(ends), new THREE.LineBasicMaterial({color: kSeen})));
  }

  /** Both images: fields in which corners were found, and the corners of now. */
  private drawMap({sides = [], columns = 8, rows = 6}: CourseStatus['details']) {
    const context = this.map.getContext('2d')!, {width, height} = this.map;
    const style = getComputedStyle(document.documentElement);
    const colour = (name: string) => style.getPropertyValue(name).trim();
    context.clearRect(0, 0, width, height);
    const one = (width - 10) / 2;
    sides.forEach(({fields = [], corners = []}, side) => {
      const from = side * (one + 10);
      for (let at = 0; at < columns * rows; ++at) {
        const x = from + (at % columns) * one / columns, y = Math.floor(at / columns) * height / rows;
        context.fillStyle = fields.includes(at) ? colour('--covered') : colour('--ground');
        context.fillRect(x + 1, y + 1, one / columns - 2, height / rows - 2);
      }
      context.fillStyle = colour('--text');
      for (const [u, v] of corners) context.fillRect(from + u * one - 1.5, v * height - 1.5, 3, 3);
    });
    const {pictures, needed, pattern} = this.status!.details;
    this.map.setAttribute('aria-label', `Coverage: left ${sides[0]?.fields?.length ?? 0}, right ${sides[1]?.fields?.length ?? 0} of ${columns * rows} fields; ${pictures} of ${needed} pictures; board ${pattern || 'unknown'}`);
  }
}
