// The range of each joint in the 3-D view: an arc (a line where it slides) from limit to limit, and a pointer at its position.
import * as THREE from 'three';
import type {URDFJoint, URDFRobot} from 'urdf-loader';
import type {Joint} from './messages';

const kNear = 0.05;  // of the range: a joint that is nearer to a limit is marked
const kArc = 0x56b4e9, kPointer = 0xe69f00, kMarked = 0xd55e00;
const kX = new THREE.Vector3(1, 0, 0), kZ = new THREE.Vector3(0, 0, 1);

interface Range { name: string; lower: number; upper: number; arc: THREE.Object3D; pointer: THREE.Object3D; marked: boolean; position: number }

/** A unit vector at right angles to `axis`: where the next joint or link lies, if that is beside the axis. */
function across(axis: THREE.Vector3, joint: URDFJoint): THREE.Vector3 {
  let towards = new THREE.Vector3();
  joint.traverse(object => { if (towards.lengthSq() < 1e-8 && object !== joint && 'isURDFJoint' in object) towards = joint.worldToLocal(object.getWorldPosition(new THREE.Vector3())); });
  towards.projectOnPlane(axis);
  if (towards.lengthSq() < 1e-6) towards.crossVectors(axis, Math.abs(axis.dot(kX)) < 0.9 ? kX : kZ);
  return towards.normalize();
}

function band(material: THREE.Material, radius: number, from: number, to: number): THREE.Object3D {
  return new THREE.Mesh(new THREE.RingGeometry(0.9 * radius, radius, 40, 1, from, to - from), material);
}

/** A pointer of some width: lines are one pixel thin. */
function bar(material: THREE.Material, from: number, to: number, width: number): THREE.Object3D {
  const made = new THREE.Mesh(new THREE.PlaneGeometry(to - from, width), material);
  made.position.x = (from + to) / 2;
  return made;
}

export class JointLimits {
  private readonly ranges = new Map<string, Range>();

  /** Adds the marks to the robot's joints, at position zero. */
  constructor(robot: URDFRobot, joints: Joint[], reach: number) {
    const radius = 0.21 * reach;
    robot.updateMatrixWorld(true);
    for (const {name, type, lower, upper} of joints) {
      const joint = robot.joints[name];
      if (!joint?.parent || lower === null || upper === null || type === 'continuous') continue;
      const slides = type === 'prismatic';
      const axis = joint.axis.clone().normalize(), reference = slides ? axis : across(axis, joint);
      const normal = slides ? across(axis, joint) : axis;
      const basis = new THREE.Matrix4().makeBasis(reference, normal.clone().cross(reference), normal);
      const still = new THREE.Group(), moving = new THREE.Group();
      // Drawn over the arm, so that its inside is seen, and light enough that the arm is seen below.
      const flat = {side: THREE.DoubleSide, transparent: true, depthTest: false, depthWrite: false};
      const pale = new THREE.MeshBasicMaterial({...flat, color: kArc, opacity: 0.55}), strong = new THREE.MeshBasicMaterial({...flat, color: kPointer, opacity: 0.9});
      const frame = new THREE.Group(), end = new THREE.Group();
      for (const group of [frame, end]) group.quaternion.setFromRotationMatrix(basis);
      if (slides) {
        frame.add(bar(pale, lower, upper, 0.1 * radius));
        end.add(bar(strong, -0.05 * radius, 0.05 * radius, 0.5 * radius));
      } else {
        frame.add(band(pale, radius, lower, Math.min(upper, lower + 2 * Math.PI)));
        end.add(bar(strong, 0.55 * radius, 1.12 * radius, 0.06 * radius));
      }
      still.position.copy(joint.position);
      still.quaternion.copy(joint.quaternion);
      still.add(frame);
      moving.add(end);
      joint.parent.add(still);
      joint.add(moving);
      for (const group of [frame, end]) group.traverse(object => { object.renderOrder = group === end ? 1.5 : 1; object.raycast = () => {}; });
      this.ranges.set(name, {name, lower, upper, arc: still, pointer: moving, marked: false, position: 0});
    }
  }

  show(visible: boolean) {
    for (const {arc, pointer} of this.ranges.values()) arc.visible = pointer.visible = visible;
  }

  set(positions: Record<string, number>) {
    for (const [name, position] of Object.entries(positions)) {
      const range = this.ranges.get(name);
      if (!range) continue;
      range.position = position;
      const margin = kNear * (range.upper - range.lower);
      const marked = position < range.lower + margin || position > range.upper - margin;
      if (marked === range.marked) continue;
      range.marked = marked;
      range.pointer.traverse(object => {
        if (!(object instanceof THREE.Mesh)) return;
        object.material.color.setHex(marked ? kMarked : kPointer);
        object.scale.setScalar(1).y = marked ? 3 : 1;  // also told apart without colour
      });
    }
  }

  /** The joints that are near a limit, in words. */
  words(): string[] {
    return [...this.ranges.values()].filter(({marked}) => marked)
      .map(({name, lower, upper, position}) => `${name} near its ${position - lower < upper - position ? 'lower' : 'upper'} limit`);
  }
}
