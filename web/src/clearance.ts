// The distance between the arm and what stands around it: links as the controller has them, capsules between their joints.
import * as THREE from 'three';
import type {Obstacle} from './messages';

export interface Clearance { distance: number; onArm: THREE.Vector3; onObstacle: THREE.Vector3; obstacle: number; link: number }

const kSteps = 40;  // of a search that keeps 0.618 of the interval in each
const kRatio = (Math.sqrt(5) - 1) / 2;

/** The point of an obstacle's skeleton nearest to `p`, both in its frame: its surface is `radius` from the skeleton. */
function skeleton({shape, size_m}: Obstacle, p: THREE.Vector3): {point: THREE.Vector3; radius: number} {
  if (shape === 1) return {point: new THREE.Vector3(0, 0, THREE.MathUtils.clamp(p.z, -0.5 * size_m[1], 0.5 * size_m[1])), radius: size_m[0]};
  if (shape === 2) {
    const half = new THREE.Vector3(...size_m as [number, number, number]).multiplyScalar(0.5);
    return {point: p.clone().clamp(half.clone().negate(), half), radius: 0};
  }
  return {point: new THREE.Vector3(), radius: size_m[0]};
}

/** Between the segment from `a` to `b`, as thick as `radius`, and an obstacle; points in W. Negative where they overlap: then by how much
 *  the surfaces do, except inside of a box, where it is at least minus `radius`. */
export function capsuleClearance(a: THREE.Vector3, b: THREE.Vector3, radius: number, obstacle: Obstacle): Omit<Clearance, 'obstacle' | 'link'> {
  const [w, x, y, z] = obstacle.orientation_wxyz;
  const X_WO = new THREE.Matrix4().compose(new THREE.Vector3(...obstacle.position_m as [number, number, number]), new THREE.Quaternion(x, y, z, w).normalize(), new THREE.Vector3(1, 1, 1));
  const X_OW = X_WO.clone().invert();
  const from = a.clone().applyMatrix4(X_OW), to = b.clone().applyMatrix4(X_OW);
  const at = (t: number) => from.clone().lerp(to, t);
  const apart = (t: number) => at(t).distanceTo(skeleton(obstacle, at(t)).point);
  // The distance from a convex body is convex along a line.
  let low = 0, high = 1, left = 1 - kRatio, right = kRatio, atLeft = apart(left), atRight = apart(right);
  for (let step = 0; step < kSteps; ++step) {
    if (atLeft <= atRight) {
      [high, right, atRight] = [right, left, atLeft];
      left = high - kRatio * (high - low);
      atLeft = apart(left);
    } else {
      [low, left, atLeft] = [left, right, atRight];
      right = low + kRatio * (high - low);
      atRight = apart(right);
    }
  }
  const p = at((low + high) / 2), {point, radius: thickness} = skeleton(obstacle, p);
  const towards = point.clone().sub(p), distance = towards.length();
  if (distance > 1e-9) towards.divideScalar(distance);
  else towards.set(0, 0, 1);
  return {
    distance: distance - radius - thickness,
    onArm: p.clone().addScaledVector(towards, radius).applyMatrix4(X_WO),
    onObstacle: point.clone().addScaledVector(towards, -thickness).applyMatrix4(X_WO),
  };
}

/** The nearest of all; nothing without obstacles. `joints`: positions of the joints in W, and of the end effector. */
export function nearest(joints: THREE.Vector3[], radius: number, obstacles: Obstacle[]): Clearance | undefined {
  let found: Clearance | undefined;
  for (let link = 0; link + 1 < joints.length; ++link) {
    if (joints[link].distanceTo(joints[link + 1]) < 1e-6) continue;
    for (const [obstacle, each] of obstacles.entries()) {
      const clearance = capsuleClearance(joints[link], joints[link + 1], radius, each);
      if (!found || clearance.distance < found.distance) found = {...clearance, obstacle, link};
    }
  }
  return found;
}
