// What the 3-D view shows besides the arm: target, hand trail, obstacles, cameras.
import * as THREE from 'three';
import type {Clearance} from './clearance';
import type {Camera, Obstacle, Target} from './messages';

export const colours = {target: 0xcc79a7, coasting: 0xe69f00, trail: 0xd55e00, compared: 0xe69f00, obstacle: 0x7f6a00, camera: 0x009e73, clearance: 0xd55e00};

/** Eigenvalues and eigenvectors of a symmetric 3 x 3 matrix, by Jacobi's rotations. */
export function eigenvectors(matrix: number[][]): {values: number[]; vectors: THREE.Vector3[]} {
  const a = matrix.map(row => [...row]);
  const v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let sweep = 0; sweep < 12; ++sweep) {
    for (const [p, q] of [[0, 1], [0, 2], [1, 2]]) {
      if (a[p][q] === 0) continue;
      const angle = 0.5 * Math.atan2(2 * a[p][q], a[q][q] - a[p][p]);
      const c = Math.cos(angle), s = Math.sin(angle);
      for (let k = 0; k < 3; ++k) [a[k][p], a[k][q]] = [c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]];
      for (let k = 0; k < 3; ++k) [a[p][k], a[q][k]] = [c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]];
      for (let k = 0; k < 3; ++k) [v[k][p], v[k][q]] = [c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]];
    }
  }
  return {values: [0, 1, 2].map(i => a[i][i]), vectors: [0, 1, 2].map(i => new THREE.Vector3(v[0][i], v[1][i], v[2][i]))};
}

export class TargetMarker {
  readonly root = new THREE.Group();
  private readonly ellipsoid: THREE.Mesh<THREE.SphereGeometry, THREE.MeshLambertMaterial>;
  private readonly cross: THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial>;
  private readonly least: number;

  constructor(reach: number) {
    this.least = 0.015 * reach;
    this.ellipsoid = new THREE.Mesh(new THREE.SphereGeometry(1, 20, 14), new THREE.MeshLambertMaterial({color: colours.target, transparent: true, opacity: 0.8, depthTest: false}));
    this.ellipsoid.matrixAutoUpdate = false;
    const arm = 0.08 * reach;
    const points = [[-arm, 0, 0], [arm, 0, 0], [0, -arm, 0], [0, arm, 0], [0, 0, -arm], [0, 0, arm]].map(p => new THREE.Vector3(...p));
    this.cross = new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({color: colours.target, depthTest: false, transparent: true}));
    // Seen through the hand that reaches it.
    this.ellipsoid.renderOrder = this.cross.renderOrder = 1;
    this.root.add(this.ellipsoid, this.cross);
    this.root.visible = false;
  }

  /** The ellipsoid of two standard deviations, ten times as large: they are millimetres. */
  show(target: Target, seen: boolean, tracked: boolean) {
    this.root.visible = seen;
    this.root.position.fromArray(target.position_m);
    const {values, vectors} = eigenvectors(target.covariance_m2);
    const axes = vectors.map((vector, i) => vector.multiplyScalar(Math.max(20 * Math.sqrt(Math.max(values[i], 0)), this.least)));
    this.ellipsoid.matrix.makeBasis(axes[0], axes[1], axes[2]);
    this.ellipsoid.matrixWorldNeedsUpdate = true;
    const colour = tracked ? colours.target : colours.coasting;
    this.ellipsoid.material.color.setHex(colour);
    this.ellipsoid.material.wireframe = !tracked;
    this.cross.material.color.setHex(colour);
  }
}

/** From the arm to the nearest point of an obstacle. */
export class ClearanceLine {
  readonly root = new THREE.Group();
  private readonly line = new THREE.Line(new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3()]), new THREE.LineBasicMaterial({color: colours.clearance, depthTest: false, transparent: true}));
  private readonly ends = new THREE.Points(this.line.geometry, new THREE.PointsMaterial({color: colours.clearance, size: 7, sizeAttenuation: false, depthTest: false, transparent: true}));

  constructor() {
    this.root.add(this.line, this.ends);
    this.root.visible = this.line.frustumCulled = this.ends.frustumCulled = false;
    this.line.renderOrder = this.ends.renderOrder = 2;
  }

  /** Returns whether that changes the picture. */
  show(clearance?: Clearance): boolean {
    const before = this.root.visible;
    this.root.visible = clearance !== undefined;
    if (!clearance) return before;
    this.line.geometry.setFromPoints([clearance.onArm, clearance.onObstacle]);
    return true;
  }
}

export class Trail {
  readonly line: THREE.Points;
  private readonly positions: Float32Array;
  private count = 0;
  private next = 0;

  constructor(private readonly most: number, size: number, colour = colours.trail) {
    this.positions = new Float32Array(3 * most);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(this.positions, 3));
    geometry.setDrawRange(0, 0);
    this.line = new THREE.Points(geometry, new THREE.PointsMaterial({color: colour, size}));
    this.line.frustumCulled = false;
  }

  clear() {
    this.count = this.next = 0;
    this.line.geometry.setDrawRange(0, 0);
  }

  add(point: THREE.Vector3) {
    point.toArray(this.positions, 3 * this.next);
    this.next = (this.next + 1) % this.most;
    this.count = Math.min(this.count + 1, this.most);
    this.line.geometry.setDrawRange(0, this.count);
    this.line.geometry.attributes.position.needsUpdate = true;
  }
}

export function obstacleMesh(obstacle: Obstacle): THREE.Object3D {
  const [a, b, c] = obstacle.size_m;
  let geometry: THREE.BufferGeometry = new THREE.SphereGeometry(a, 20, 14);
  if (obstacle.shape === 1) geometry = new THREE.CapsuleGeometry(a, b, 6, 18).rotateX(Math.PI / 2);
  if (obstacle.shape === 2) geometry = new THREE.BoxGeometry(a, b, c);
  const mesh = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({color: colours.obstacle, transparent: true, opacity: 0.55}));
  const [w, x, y, z] = obstacle.orientation_wxyz;
  mesh.quaternion.set(x, y, z, w);
  mesh.position.fromArray(obstacle.position_m);
  return mesh;
}

/** The camera's viewing pyramid up to `depth` metres. */
export function frustum(camera: Camera, depth: number): THREE.Object3D {
  const corner = (u: number, v: number) => new THREE.Vector3((u - camera.cx_px) / camera.fx_px * depth, (v - camera.cy_px) / camera.fy_px * depth, depth);
  const corners = [corner(0, 0), corner(camera.width_px, 0), corner(camera.width_px, camera.height_px), corner(0, camera.height_px)];
  const points: THREE.Vector3[] = [];
  corners.forEach((each, i) => points.push(new THREE.Vector3(), each, each, corners[(i + 1) % 4]));
  const lines = new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({color: colours.camera}));
  const m = camera.X_WC;
  lines.applyMatrix4(new THREE.Matrix4(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11], m[12], m[13], m[14], m[15]));
  return lines;
}
