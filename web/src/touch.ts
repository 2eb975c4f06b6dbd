// What the user moves by hand: the page's target, obstacles, and pushes on a simulated arm.
import * as THREE from 'three';
import type {Answer, Obstacle, Target, TargetChoice} from './messages';
import {element, isTyping, showsLog} from './controls';
import type {Scene} from './scene';

const kSend = 50;         // ms from one message of a drag to the next
const kKeepAlive = 1000;  // ms: the server gives the target to another browser when this one is not heard for long
const kPageTarget = 'page';
const kNamed = 1;         // target_choice_t
const kShapes = ['sphere', 'capsule', 'box'];
const kAxes = ['x', 'y', 'z'] as const;
const kSelected = 0xffffff, kHandle = 0xf0e442;

/** What can be dragged: the target, an obstacle, or a link of the arm that is pushed. */
type Grip = {kind: 'target'} | {kind: 'obstacle'; index: number} | {kind: 'link'; link: string; from: THREE.Vector3};

function clientId(): string {
  let id = sessionStorage.getItem('client');
  if (!id) sessionStorage.setItem('client', id = Array.from(crypto.getRandomValues(new Uint32Array(3)), value => value.toString(36)).join(''));
  return id;
}

export class Touch {
  readonly client = clientId();
  private readonly handle: THREE.Group;
  private readonly arrow = new THREE.ArrowHelper(new THREE.Vector3(1, 0, 0), new THREE.Vector3(), 0.1, kHandle);
  private readonly raycaster = new THREE.Raycaster();
  private readonly plane = new THREE.Plane();
  private readonly select = element<HTMLSelectElement>('selected');
  private readonly inputs = kAxes.map(axis => element<HTMLInputElement>(`at-${axis}`));
  private held = false;
  private grip?: Grip;
  private offset = new THREE.Vector3();
  private obstacles: Obstacle[] = [];
  private choice?: TargetChoice;
  private targets = new Map<string, Target>();
  private due = {target: false, obstacles: false};
  private sent = {target: 0, obstacles: 0};
  private reach = 1;
  private simulated = true;
  private tip = '';
  private listed = '';

  constructor(private readonly scene: Scene, private readonly send: (request: object) => boolean) {
    this.handle = new THREE.Group();
    this.handle.visible = this.arrow.visible = false;
    scene.overlay.add(this.handle, this.arrow);
    const {canvas} = scene;
    canvas.addEventListener('pointerdown', event => this.down(event), {capture: true});
    canvas.addEventListener('pointermove', event => this.move(event), {capture: true});
    for (const type of ['pointerup', 'pointercancel'] as const) canvas.addEventListener(type, event => this.up(event), {capture: true});
    canvas.addEventListener('keydown', event => this.nudge(event), {capture: true});
    addEventListener('keydown', event => this.key(event));
    element('take').addEventListener('click', () => this.take(!this.held));
    element('add-obstacle').addEventListener('click', () => this.addObstacle());
    element('remove-obstacle').addEventListener('click', () => this.removeObstacle());
    element('push').addEventListener('click', () => this.pushHand());
    this.select.addEventListener('change', () => this.showSelected());
    this.inputs.forEach((input, i) => input.addEventListener('change', () => this.place(i, Number(input.value))));
    setInterval(() => this.tick(), kSend);
    Object.assign(window, {touchHandle: () => scene.pixelOf(this.handle.position)});  // for tests
    this.list();
  }

  setup(reach: number, tip: string) {
    this.reach = reach;
    this.tip = tip;
    this.handle.clear();
    const ball = new THREE.Mesh(new THREE.SphereGeometry(0.045 * reach, 20, 14), new THREE.MeshBasicMaterial({color: kHandle, transparent: true, opacity: 0.55, depthTest: false}));
    const ring = new THREE.Mesh(new THREE.SphereGeometry(0.047 * reach, 8, 6), new THREE.MeshBasicMaterial({color: 0x222222, wireframe: true, depthTest: false, transparent: true, opacity: 0.5}));
    ball.renderOrder = ring.renderOrder = 2;
    this.handle.add(ball, ring);
    if (sessionStorage.getItem('held') === this.client) this.resume();
  }

  robot(simulated: boolean) { this.simulated = simulated; }

  /** Whether the controller follows a target of this name, as far as the page knows. */
  follows(name: string): boolean { return this.choice?.kind === kNamed ? name === this.choice.name : name !== kPageTarget; }
  target(target: Target) { this.targets.set(target.name, target); }

  choose(choice: TargetChoice) {
    this.choice = choice;
    const chosen = choice.kind === kNamed && choice.name === kPageTarget;
    document.documentElement.dataset.choice = choice.kind === kNamed ? choice.name : '';
    if (!chosen && this.held && performance.now() - this.sent.target > 3 * kKeepAlive) this.setHeld(false);
  }

  known(obstacles: Obstacle[]) {
    if (this.grip?.kind === 'obstacle' || this.due.obstacles) return;
    this.obstacles = obstacles;
    this.list();
  }

  answer(answer: Answer) {
    if (answer.answer === 'target' && !answer.accepted) this.setHeld(false);
  }

  private setHeld(held: boolean) {
    this.held = held;
    this.handle.visible = held;
    element('take').setAttribute('aria-pressed', String(held));
    if (held) sessionStorage.setItem('held', this.client);
    else sessionStorage.removeItem('held');
    this.scene.redraw();
    this.list();
  }

  private resume() {
    const page = this.targets.get(kPageTarget);
    if (page) this.handle.position.fromArray(page.position_m);
    else this.handle.position.copy(this.scene.hand());
    this.setHeld(true);
  }

  private take(held: boolean) {
    if (!held) {
      this.send({request: 'release', client: this.client});
      this.setHeld(false);
      return;
    }
    const followed = [...this.targets.values()].find(target => this.follows(target.name) && (target.status === 1 || target.status === 2));
    if (followed) this.handle.position.fromArray(followed.position_m);
    else this.handle.position.copy(this.scene.hand());
    this.setHeld(true);
    this.select.value = 'target';
    this.showSelected();
    this.due.target = true;
    this.tick();
  }

  private addObstacle() {
    const radius = 0.08 * this.reach;
    const at = this.scene.hand().add(this.scene.right().multiplyScalar(3 * radius));
    this.obstacles = [...this.obstacles, {name: `page ${this.obstacles.length + 1}`, shape: 0, position_m: at.toArray(), orientation_wxyz: [1, 0, 0, 0], size_m: [radius, 0, 0]}];
    this.changed(this.obstacles.length - 1);
  }

  private removeObstacle() {
    const index = this.selectedObstacle();
    if (index === undefined) return;
    this.obstacles = this.obstacles.filter((_, i) => i !== index);
    this.changed(Math.min(index, this.obstacles.length - 1));
  }

  private changed(select: number) {
    this.due.obstacles = true;
    this.scene.setObstacles(this.obstacles);
    this.list();
    if (select >= 0) this.select.value = `obstacle ${select}`;
    this.showSelected();
    this.tick();
  }

  private pushHand() {
    this.push(this.tip, this.scene.direction().multiplyScalar(30 * this.reach));
  }

  private push(link: string, force: THREE.Vector3) {
    this.send({request: 'push', link, force_n: force.toArray(), duration_s: 0.3});
  }

  private selectedObstacle(): number | undefined {
    const found = /^obstacle (\d+)$/.exec(this.select.value);
    return found && Number(found[1]) < this.obstacles.length ? Number(found[1]) : undefined;
  }

  /** Fills the list of what can be moved. */
  private list() {
    const names = [...(this.held ? ['target'] : []), ...this.obstacles.map((_, i) => `obstacle ${i}`)];
    const text = names.join();
    if (text !== this.listed) {
      this.listed = text;
      const before = this.select.value;
      this.select.replaceChildren(...names.map(name => new Option(name.replace(/\d+$/, number => String(Number(number) + 1)), name)));
      if (names.includes(before)) this.select.value = before;
    }
    this.showSelected();
  }

  private positionOf(): THREE.Vector3 | undefined {
    const index = this.selectedObstacle();
    if (index !== undefined) return new THREE.Vector3(...this.obstacles[index].position_m);
    return this.select.value === 'target' && this.held ? this.handle.position.clone() : undefined;
  }

  private showSelected() {
    const position = this.positionOf();
    const none = !position;
    for (const [i, input] of this.inputs.entries()) {
      if (input.disabled !== none) input.disabled = none;
      const text = position ? position.getComponent(i).toFixed(3) : '';
      if (document.activeElement !== input && input.value !== text) input.value = text;
    }
    this.select.disabled = this.listed === '';
    element<HTMLButtonElement>('remove-obstacle').disabled = this.selectedObstacle() === undefined;
    this.scene.highlightObstacle(this.selectedObstacle(), kSelected);
  }

  private place(axis: number, value: number) {
    const position = this.positionOf();
    if (!position || !Number.isFinite(value)) return;
    this.moveTo(position.setComponent(axis, value));
  }

  private moveTo(position: THREE.Vector3) {
    const index = this.selectedObstacle();
    if (index !== undefined) {
      this.obstacles = this.obstacles.map((each, i) => i === index ? {...each, position_m: position.toArray()} : each);
      this.scene.setObstacles(this.obstacles);
      this.due.obstacles = true;
    } else if (this.held) {
      this.handle.position.copy(position);
      this.due.target = true;
    }
    this.scene.redraw();
    this.showSelected();
  }

  private key(event: KeyboardEvent) {
    if (showsLog() || event.ctrlKey || event.altKey || event.metaKey || event.repeat || isTyping(event)) return;
    const actions: Record<string, () => void> = {g: () => this.take(!this.held), o: () => this.addObstacle(), delete: () => this.removeObstacle(), u: () => this.pushHand()};
    actions[event.key.toLowerCase()]?.();
  }

  /** Shift and arrows move what is selected in the plane of the view, page up and down along the view; + and - change its size. */
  private nudge(event: KeyboardEvent) {
    if (!event.shiftKey) return;
    const step = 0.03 * this.reach;
    const ways: Record<string, THREE.Vector3> = {
      ArrowLeft: this.scene.right().negate(), ArrowRight: this.scene.right(), ArrowUp: this.scene.up(), ArrowDown: this.scene.up().negate(),
      PageUp: this.scene.direction(), PageDown: this.scene.direction().negate(),
    };
    const position = this.positionOf(), way = ways[event.key], index = this.selectedObstacle();
    const scale = event.key === '+' || event.key === '*' ? 1.15 : event.key === '_' || event.key === '-' ? 1 / 1.15 : 0;
    if (position && way) this.moveTo(position.addScaledVector(way, step));
    else if (index !== undefined && scale) {
      this.obstacles = this.obstacles.map((each, i) => i === index ? {...each, size_m: each.size_m.map(value => value * scale)} : each);
      this.changed(index);
    } else return;
    event.preventDefault();
    event.stopImmediatePropagation();
  }

  private aim(event: PointerEvent) {
    const {left, top, width, height} = this.scene.canvas.getBoundingClientRect();
    this.scene.camera.updateMatrixWorld();  // the last frame may be older than the last change
    this.handle.updateMatrixWorld();
    this.raycaster.setFromCamera(new THREE.Vector2(2 * (event.clientX - left) / width - 1, 1 - 2 * (event.clientY - top) / height), this.scene.camera);
  }

  private gripAt(event: PointerEvent): {grip: Grip; at: THREE.Vector3} | undefined {
    this.aim(event);
    if (this.held && this.raycaster.intersectObject(this.handle, true).length > 0) return {grip: {kind: 'target'}, at: this.handle.position.clone()};
    const index = this.scene.obstacleAt(this.raycaster);
    if (index !== undefined) return {grip: {kind: 'obstacle', index}, at: new THREE.Vector3(...this.obstacles[index].position_m)};
    const link = event.shiftKey && this.simulated ? this.scene.linkAt(this.raycaster) : undefined;
    return link && {grip: {kind: 'link', link: link.name, from: link.point}, at: link.point.clone()};
  }

  private down(event: PointerEvent) {
    if (event.button !== 0) return;
    const found = this.gripAt(event);
    if (!found) return;
    event.stopImmediatePropagation();
    this.scene.canvas.focus();
    this.scene.canvas.setPointerCapture(event.pointerId);
    this.grip = found.grip;
    this.plane.setFromNormalAndCoplanarPoint(this.scene.direction(), found.at);
    const hit = this.raycaster.ray.intersectPlane(this.plane, new THREE.Vector3());
    this.offset.copy(found.at).sub(hit ?? found.at);
    if (found.grip.kind !== 'link') {
      this.select.value = found.grip.kind === 'target' ? 'target' : `obstacle ${found.grip.index}`;
      this.showSelected();
    }
  }

  private move(event: PointerEvent) {
    if (!this.grip) return;
    event.stopImmediatePropagation();
    this.aim(event);
    const hit = this.raycaster.ray.intersectPlane(this.plane, new THREE.Vector3());
    if (!hit) return;
    if (this.grip.kind !== 'link') return this.moveTo(hit.add(this.offset));
    const pull = hit.sub(this.grip.from);
    this.arrow.visible = pull.length() > 0;
    this.arrow.position.copy(this.grip.from);
    if (this.arrow.visible) {
      this.arrow.setDirection(pull.clone().normalize());
      this.arrow.setLength(pull.length(), 0.06 * this.reach, 0.03 * this.reach);
    }
    this.arrow.userData.pull = pull;
    this.scene.redraw();
  }

  private up(event: PointerEvent) {
    if (!this.grip) return;
    event.stopImmediatePropagation();
    if (this.grip.kind === 'link' && this.arrow.visible && event.type === 'pointerup') {
      const pull = this.arrow.userData.pull as THREE.Vector3;
      this.push(this.grip.link, pull.clone().multiplyScalar(60).clampLength(0, 60 * this.reach));  // N per metre
    }
    this.arrow.visible = false;
    this.grip = undefined;
    this.scene.redraw();
    this.tick();
  }

  private tick() {
    const now = performance.now();
    if (this.held && (this.due.target || now - this.sent.target > kKeepAlive)) {
      if (this.send({request: 'target', client: this.client, position_m: this.handle.position.toArray()})) this.due.target = false;
      this.sent.target = now;
    }
    if (this.due.obstacles && (this.grip?.kind !== 'obstacle' || now - this.sent.obstacles > 4 * kSend)) {
      const obstacles = this.obstacles.map(({name, shape, position_m, orientation_wxyz, size_m}) =>
        ({name, shape: kShapes[shape], position_m, orientation_wxyz, size_m: size_m.slice(0, shape + 1)}));
      if (this.send({request: 'obstacles', obstacles})) this.due.obstacles = false;
      this.sent.obstacles = now;
    }
  }
}
