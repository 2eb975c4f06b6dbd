// The arm, drawn from its URDF; links without shapes as capsules between their joints.
import * as THREE from 'three';
import URDFLoader, {type URDFLink, type URDFRobot} from 'urdf-loader';
import {JointLimits} from './limits';
import type {Setup} from './messages';

const kY = new THREE.Vector3(0, 1, 0);

export class Arm {
  readonly root = new THREE.Group();  // its frame is W
  private readonly robot: URDFRobot;
  private readonly tip: THREE.Object3D;
  private readonly base: THREE.Object3D;

  /** `ghost`: draws the moving links only, see-through, in this colour; `grid`: as a grid of lines. */
  constructor(setup: Setup, private readonly ghost: boolean, private readonly colour = 0x0072b2, private readonly grid = false) {
    const loader = new URDFLoader();
    loader.parseCollision = false;
    loader.loadMeshCb = (_path, _manager, _material, done) => done(new THREE.Group());  // meshes are not served
    this.robot = loader.parse(setup.urdf);
    this.base = this.robot.links[setup.base] ?? this.robot;
    this.tip = this.robot.links[setup.tip] ?? this.base;
    for (const joint of Object.values(this.robot.joints)) joint.ignoreLimits = true;
    this.addShapes(setup);
    this.paint();
    this.root.add(this.robot);
    this.place();
  }

  set(positions: Record<string, number>) {
    for (const [name, value] of Object.entries(positions)) this.robot.joints[name]?.setJointValue(value);
    this.place();
  }

  /** The measured arm's ranges of joints; call it once. */
  addLimits(setup: Setup): JointLimits { return new JointLimits(this.robot, setup.joints, setup.reach_m); }

  /** In W: where the joints of the chain are, and its end. */
  jointPositions(names: string[]): THREE.Vector3[] {
    const objects = [...names.map(name => this.robot.joints[name]).filter(joint => joint !== undefined), this.tip];
    return objects.map(object => this.root.worldToLocal(object.getWorldPosition(new THREE.Vector3())));
  }

  handPosition(): THREE.Vector3 { return this.root.worldToLocal(this.tip.getWorldPosition(new THREE.Vector3())); }
  linkAt(raycaster: THREE.Raycaster): {name: string; point: THREE.Vector3} | undefined {
    const hit = raycaster.intersectObject(this.robot, true)[0];
    return hit && {name: linkOf(hit.object).name, point: hit.point};
  }
  bounds(): THREE.Box3 { return new THREE.Box3().setFromObject(this.robot); }

  /** Moves the robot so that the base link's frame is W. */
  private place() {
    this.robot.matrixAutoUpdate = true;
    this.robot.position.set(0, 0, 0);
    this.robot.quaternion.identity();
    this.robot.updateMatrixWorld(true);
    const X = this.root.matrixWorld.clone().invert().multiply(this.base.matrixWorld).invert();
    X.decompose(this.robot.position, this.robot.quaternion, new THREE.Vector3());
    this.robot.updateMatrixWorld(true);
  }

  private addShapes(setup: Setup) {
    const radius = setup.link_radius_m > 0 ? setup.link_radius_m : 0.045 * setup.reach_m;
    for (const {name} of setup.joints) {
      const joint = this.robot.joints[name];
      if (!joint) continue;
      const link = joint.children.find(child => 'isURDFLink' in child) as URDFLink | undefined;
      if (!this.ghost) joint.add(this.hinge(joint.axis, 1.1 * radius));
      if (link && !hasShape(link)) this.addCapsules(link, radius);
    }
  }

  private hinge(axis: THREE.Vector3, radius: number): THREE.Object3D {
    const hinge = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, 1.6 * radius, 20), material(0x59636f));
    hinge.quaternion.setFromUnitVectors(kY, axis.clone().normalize());
    return hinge;
  }

  /** From the link's origin to each of its joints. */
  private addCapsules(link: URDFLink, radius: number) {
    for (const child of link.children) {
      if (!('isURDFJoint' in child)) continue;
      const length = child.position.length();
      if (length < 0.5 * radius) continue;
      const capsule = new THREE.Mesh(new THREE.CapsuleGeometry(0.8 * radius, length, 4, 16), material(0x8fa1b8));
      capsule.quaternion.setFromUnitVectors(kY, child.position.clone().normalize());
      capsule.position.copy(child.position).multiplyScalar(0.5);
      link.add(capsule);
    }
  }

  private paint() {
    const moving = new Set<THREE.Object3D>();
    for (let at: THREE.Object3D | null = this.tip; at && at !== this.base; at = at.parent) if ('isURDFLink' in at) moving.add(at);
    // Slightly further away than it is, so that it is seen only where it differs from the measured arm.
    const ghost = new THREE.MeshLambertMaterial({color: this.colour, wireframe: this.grid, transparent: true, opacity: this.grid ? 0.8 : 0.45, depthWrite: false, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2});
    this.robot.traverse(object => {
      if (!(object instanceof THREE.Mesh)) return;
      if (this.ghost) {
        object.material = ghost;
        object.visible = moving.has(linkOf(object));
      } else {
        const colour = (object.material as THREE.MeshPhongMaterial).color;
        object.material = material(colour?.getHex() ?? 0x8fa1b8);
      }
    });
  }
}

function material(colour: number) { return new THREE.MeshLambertMaterial({color: colour}); }

function linkOf(object: THREE.Object3D): THREE.Object3D {
  let at: THREE.Object3D = object;
  while (at.parent && !('isURDFLink' in at)) at = at.parent;
  return at;
}

function hasShape(link: URDFLink): boolean {
  let found = false;
  for (const child of link.children) {
    if ('isURDFVisual' in child) child.traverse(object => { found ||= object instanceof THREE.Mesh; });
  }
  return found;
}

