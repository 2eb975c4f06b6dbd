// The 3-D view. W is the scene's frame, z up.
import * as THREE from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {Arm} from './arm';
import {nearest, type Clearance} from './clearance';
import type {JointLimits} from './limits';
import {ClearanceLine, TargetMarker, Trail, colours, frustum, obstacleMesh} from './markers';
import type {Obstacle, Setup, Target} from './messages';

export type PointOfView = 'perspective' | 'front' | 'side' | 'top';

const kDirections: Record<PointOfView, [number, number, number]> = {
  perspective: [0.75, -1, 0.7], front: [1, 0, 0.001], side: [0, -1, 0.001], top: [0.001, 0, 1],
};
const kTrailPoints = 250;  // ten seconds
const kLow = 300;  // pixels: a view that is lower shows the arm without the cameras

/** Whether the browser has no GPU to draw with; then it draws without antialiasing. */
function rendersInSoftware(): boolean {
  const context = document.createElement('canvas').getContext('webgl2');
  const info = context?.getExtension('WEBGL_debug_renderer_info');
  const name = info ? String(context?.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  context?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

function corners({min, max}: THREE.Box3): THREE.Vector3[] {
  return [0, 1, 2, 3, 4, 5, 6, 7].map(i => new THREE.Vector3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z));
}

export class Scene {
  /** For what is drawn besides; call redraw() after changes. */
  readonly overlay = new THREE.Group();
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(40, 1, 0.01, 100);
  private readonly controls: OrbitControls;
  private grid?: THREE.GridHelper;
  private measured?: Arm;
  private ghost?: Arm;
  private trail?: Trail;
  private compared?: {arm: Arm; trail: Trail};  // of another run
  private readonly targets = new Map<string, TargetMarker>();
  private readonly obstacles = new THREE.Group();
  private known: Obstacle[] = [];
  private readonly clearanceLine = new ClearanceLine();
  private limits?: JointLimits;
  private showsLimits = true;
  private joints: string[] = [];
  private linkRadius = 0;
  private readonly cameras = new THREE.Group();
  private reach = 1;
  private contents = new THREE.Group();
  private centre = new THREE.Vector3();
  private dirty = true;
  private view: PointOfView = 'perspective';
  private turned = false;  // by the user, since a point of view was chosen
  private framed = false;  // after the first measured posture
  private readonly software = rendersInSoftware();

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: !this.software, powerPreference: 'high-performance'});
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => { this.dirty = true; });
    this.controls.addEventListener('start', () => { this.turned = true; });
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x777777, 2.2), this.contents, this.obstacles, this.cameras, this.overlay, this.clearanceLine.root);
    const sun = new THREE.DirectionalLight(0xffffff, 1.6);
    sun.position.set(1, -1.5, 3);
    this.scene.add(sun);
    new ResizeObserver(() => this.resize()).observe(canvas);
    canvas.addEventListener('keydown', event => this.key(event));
  }

  setup(setup: Setup) {
    this.contents.clear();
    this.targets.clear();
    this.reach = setup.reach_m;
    this.measured = new Arm(setup, false);
    this.ghost = new Arm(setup, true);
    this.ghost.root.visible = false;
    this.trail = new Trail(kTrailPoints, 0.012 * this.reach);
    this.compared = {arm: new Arm(setup, true, colours.compared, true), trail: new Trail(kTrailPoints, 0.012 * this.reach, colours.compared)};
    this.compared.arm.root.visible = false;
    this.contents.add(this.compared.arm.root, this.compared.trail.line, this.measured.root, this.ghost.root, this.trail.line, new THREE.AxesHelper(0.2 * this.reach));
    this.cameras.clear();
    for (const camera of setup.cameras) this.cameras.add(frustum(camera, 0.3 * this.reach));
    const bounds = this.measured.bounds();
    bounds.clone().expandByPoint(this.measured.handPosition()).getCenter(this.centre);
    this.joints = setup.joints.map(({name}) => name);
    this.linkRadius = setup.link_radius_m;
    this.limits = this.measured.addLimits(setup);
    this.limits.show(this.showsLimits);
    this.addGrid(bounds.min.z - 0.02 * this.reach);
    this.framed = false;
    if (!this.turned) this.look(this.view);
  }

  private addGrid(height: number) {
    const size = 4 * this.reach;
    this.grid = new THREE.GridHelper(size, 16, 0x808890, 0x808890);
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.set(this.centre.x, this.centre.y, height);
    (this.grid.material as THREE.Material).transparent = true;
    (this.grid.material as THREE.Material).opacity = 0.35;
    this.contents.add(this.grid);
  }

  /** Corners of what a point of view shows. */
  private shown(): THREE.Vector3[] {
    const arm = this.measured?.bounds().expandByPoint(this.measured.handPosition()) ?? new THREE.Box3(new THREE.Vector3(), new THREE.Vector3());
    const cameras = this.cameras.children.length > 0 && this.canvas.clientHeight >= kLow;
    return [...corners(arm), ...(cameras ? corners(new THREE.Box3().setFromObject(this.cameras)) : [])];
  }

  look(from: PointOfView) {
    this.view = from;
    this.turned = false;
    const shown = this.shown();
    const direction = new THREE.Vector3(...kDirections[from]).normalize();
    const right = this.camera.up.clone().cross(direction).normalize(), up = direction.clone().cross(right);
    // The middle of what is to be seen, and the distance from which it fits.
    const centre = new THREE.Vector3();
    const half = [right, up, direction].map(axis => {
      const along = shown.map(point => point.dot(axis));
      const low = Math.min(...along), high = Math.max(...along);
      centre.addScaledVector(axis, (low + high) / 2);
      return (high - low) / 2;
    });
    const slope = Math.tan(THREE.MathUtils.degToRad(0.5 * this.camera.fov));
    const tightness = 0.95;  // the corners of what is shown are mostly empty
    const distance = tightness * (0.5 * half[2] + Math.max(half[1], half[0] / this.camera.aspect) / slope);
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(direction, distance);
    this.camera.near = 0.02 * this.reach;
    this.camera.far = 30 * this.reach;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.dirty = true;
  }

  setTheme(background: string) {
    this.scene.background = new THREE.Color(background);
    this.dirty = true;
  }

  /** Returns the position of the hand in W. */
  setMeasured(positions: Record<string, number>, trailed = true): THREE.Vector3 | undefined {
    if (!this.measured) return undefined;
    this.measured.set(positions);
    this.limits?.set(positions);
    if (!this.framed && !this.turned) this.look(this.view);
    this.framed = true;
    const hand = this.measured.handPosition();
    if (trailed) this.trail?.add(hand);
    this.dirty = true;
    return hand;
  }

  /** The arm of another run; nothing hides it. Returns the position of its hand in W. */
  setCompared(positions?: Record<string, number>, trailed = true): THREE.Vector3 | undefined {
    if (!this.compared) return undefined;
    const {arm, trail} = this.compared;
    this.dirty = true;
    arm.root.visible = positions !== undefined;
    if (!positions) {
      trail.clear();
      return undefined;
    }
    arm.set(positions);
    const hand = arm.handPosition();
    if (trailed) trail.add(hand);
    return hand;
  }

  clearTrails() {
    this.trail?.clear();
    this.compared?.trail.clear();
    this.dirty = true;
  }

  /** Where the view's camera is and what it looks at: six numbers, metres in W. */
  get pose(): number[] { return [...this.camera.position.toArray(), ...this.controls.target.toArray()]; }
  set pose(numbers: number[]) {
    if (numbers.length !== 6 || !numbers.every(Number.isFinite)) return;
    this.camera.position.fromArray(numbers);
    this.controls.target.fromArray(numbers, 3);
    this.turned = true;
    this.controls.update();
    this.dirty = true;
  }

  setGhost(positions?: Record<string, number>) {
    if (!this.ghost) return;
    this.ghost.root.visible = positions !== undefined;
    if (positions) this.ghost.set(positions);
    this.dirty = true;
  }

  setTarget(target: Target, seen: boolean, tracked: boolean) {
    let marker = this.targets.get(target.name);
    if (!marker) {
      marker = new TargetMarker(this.reach);
      this.targets.set(target.name, marker);
      this.contents.add(marker.root);
    }
    marker.show(target, seen, tracked);
    this.dirty = true;
  }

  setObstacles(obstacles: Obstacle[]) {
    this.obstacles.clear();
    for (const obstacle of obstacles) this.obstacles.add(obstacleMesh(obstacle));
    this.known = obstacles;
    this.dirty = true;
  }

  /** The distance between the measured arm and the obstacles, which a line shows; nothing without obstacles, or where the controller ignores them. */
  clearance(): Clearance | undefined {
    const found = this.measured && this.linkRadius > 0 ? nearest(this.measured.jointPositions(this.joints), this.linkRadius, this.known) : undefined;
    if (this.clearanceLine.show(found)) this.dirty = true;
    return found;
  }

  /** For tests: the clearance to the spheres among the obstacles, by sampling the links, mm. */
  sampledClearance(): number {
    const joints = this.measured!.jointPositions(this.joints), centres = this.known.map(each => new THREE.Vector3(...each.position_m));
    let least = Infinity;
    for (let link = 0; link + 1 < joints.length; ++link) {
      for (let k = 0; k <= 1000; ++k) centres.forEach((centre, i) => { least = Math.min(least, centre.distanceTo(joints[link].clone().lerp(joints[link + 1], k / 1000)) - this.known[i].size_m[0]); });
    }
    return 1e3 * (least - this.linkRadius);
  }

  set limitsShown(shown: boolean) {
    this.showsLimits = shown;
    this.limits?.show(shown);
    this.dirty = true;
  }

  /** Joints that are near a limit, in words. */
  nearLimits(): string[] { return this.limits?.words() ?? []; }

  redraw() { this.dirty = true; }

  /** The measured position of the hand. */
  hand(): THREE.Vector3 { return this.measured?.handPosition() ?? new THREE.Vector3(); }

  /** Unit vectors of the view in W: where it looks, to the right, up. */
  direction(): THREE.Vector3 { return this.camera.getWorldDirection(new THREE.Vector3()); }
  right(): THREE.Vector3 { return new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0); }
  up(): THREE.Vector3 { return new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1); }

  /** The index of the obstacle that a ray hits first. */
  obstacleAt(raycaster: THREE.Raycaster): number | undefined {
    const hit = raycaster.intersectObjects(this.obstacles.children, true)[0];
    return hit ? this.obstacles.children.indexOf(hit.object) : undefined;
  }

  /** The link of the measured arm that a ray hits first. */
  linkAt(raycaster: THREE.Raycaster): {name: string; point: THREE.Vector3} | undefined {
    return this.measured?.linkAt(raycaster);
  }

  /** The canvas' pixel, from its left top, at which a point of W is drawn. */
  pixelOf(point: THREE.Vector3): {x: number; y: number} {
    this.camera.updateMatrixWorld();
    const {x, y} = point.clone().project(this.camera);
    return {x: (x + 1) / 2 * this.canvas.clientWidth, y: (1 - y) / 2 * this.canvas.clientHeight};
  }

  highlightObstacle(index: number | undefined, colour: number) {
    for (const [i, mesh] of this.obstacles.children.entries()) {
      const material = (mesh as THREE.Mesh<THREE.BufferGeometry, THREE.MeshLambertMaterial>).material;
      const wanted = i === index ? colour : 0;
      if (material.emissive.getHex() === wanted) continue;
      material.emissive.setHex(wanted);
      material.emissiveIntensity = 0.35;
      this.dirty = true;
    }
  }

  /** Draws when something has changed; returns whether it did. */
  render(): boolean {
    if (!this.dirty) return false;
    this.dirty = false;
    this.renderer.render(this.scene, this.camera);
    return true;
  }

  private resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    if (!width || !height) return;
    this.renderer.setPixelRatio(this.software ? 1 : Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.turned && this.measured) this.look(this.view);
    this.dirty = true;
  }

  private key(event: KeyboardEvent) {
    if (event.shiftKey && event.key.startsWith('Arrow')) return;
    const turns: Record<string, [number, number]> = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1]};
    const zooms: Record<string, number> = {'+': 0.9, '=': 0.9, '-': 1.1};
    const turn = turns[event.key], zoom = zooms[event.key];
    if (!turn && !zoom) return;
    event.preventDefault();
    this.turned = true;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const turnable = new THREE.Spherical().setFromVector3(new THREE.Vector3(offset.x, offset.z, -offset.y));  // its y is up
    turnable.theta += turn?.[0] ?? 0;
    turnable.phi = Math.min(Math.max(turnable.phi + (turn?.[1] ?? 0), 0.02), Math.PI - 0.02);
    turnable.radius *= zoom ?? 1;
    const moved = new THREE.Vector3().setFromSpherical(turnable);
    this.camera.position.copy(this.controls.target).add(new THREE.Vector3(moved.x, -moved.z, moved.y));
    this.controls.update();
    this.dirty = true;
  }
}
