// The things that vision chose a target from, or could not choose from: numbered in the images and in the 3-D view, with the evidence in words.
import * as THREE from 'three';
import {element} from './controls';
import type {Camera, Setup, Target, TargetCandidate, TargetCandidates} from './messages';
import type {Scene} from './scene';

const kMost = 6;          // that are shown, best first
const kCurrent = 150000;  // us: later targets have other candidates, or need none
const kLinger = 2000;     // ms: so long the list stays when there is nothing to choose any more
const kStrong = Math.log(20), kWeak = Math.log(3);  // docs/vision.md, "which object"
const kTerms: [keyof TargetCandidate & `${string}_score`, string][] = [
  ['still_score', 'background'], ['round_score', 'shape'], ['colour_score', 'colour'], ['stereo_score', 'agreement of the images'],
  ['size_score', 'size'], ['history_score', 'prediction'],
];
const kChosen = '#f0e442', kOther = '#ffffff', kEdge = '#101010';

/** By how much something is less likely, in words, from the logarithm of a likelihood ratio. */
function lessLikely(difference: number): string {
  if (difference < 0.05) return 'as likely as 1';
  const times = Math.exp(Math.min(difference, 20));
  return times > 1000 ? 'more than 1000 times less likely than 1' : `${times < 10 ? times.toFixed(1) : Math.round(times)} times less likely than 1`;
}

/** How strongly a term speaks for or against a candidate. */
function strength(score: number): string {
  const size = Math.abs(score);
  return size >= kStrong ? 'strongly ' : size >= kWeak ? '' : 'slightly ';
}

/** The terms of the evidence, relative to `best` or, of the best itself, as they are. */
function evidence(candidate: TargetCandidate, best: TargetCandidate): string {
  const relative = candidate !== best;
  const terms = kTerms.map(([field, name]) => ({name, score: candidate[field] - (relative ? best[field] : 0)})).filter(({score}) => Math.abs(score) >= 0.1);
  terms.sort((a, b) => Math.abs(b.score) - Math.abs(a.score));
  const list = (sign: number) => terms.filter(({score}) => sign * score > 0).map(({name, score}) => `${strength(score)}${name} (${score > 0 ? '+' : '−'}${Math.abs(score).toFixed(1)})`).join(', ');
  const good = list(1), bad = list(-1);
  return [good && `for it${relative ? ', compared with 1' : ''}: ${good}`, bad && `against it${relative ? ', compared with 1' : ''}: ${bad}`].filter(Boolean).join('; ') || 'evidence as that of 1';
}

/** A number in a circle (chosen) or a dashed square. */
function mark(context: CanvasRenderingContext2D, x: number, y: number, half: number, text: string, chosen: boolean) {
  for (const [colour, width] of [[kEdge, 5], [chosen ? kChosen : kOther, 2]] as const) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.setLineDash(chosen || colour === kEdge ? [] : [5, 3]);
    context.beginPath();
    if (chosen) context.arc(x, y, half, 0, 2 * Math.PI);
    else context.rect(x - half, y - half, 2 * half, 2 * half);
    context.stroke();
  }
  context.setLineDash([]);
  context.font = '600 15px system-ui, sans-serif';
  context.textAlign = 'left';
  context.textBaseline = 'bottom';
  context.lineJoin = 'round';
  context.lineWidth = 4;
  context.strokeStyle = kEdge;
  context.strokeText(text, x + half + 2, y - half + 4);
  context.fillStyle = chosen ? kChosen : kOther;
  context.fillText(text, x + half + 2, y - half + 4);
}

function label(text: string, chosen: boolean): THREE.Sprite {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 64;
  mark(canvas.getContext('2d')!, 26, 38, 16, text, chosen);
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({map: new THREE.CanvasTexture(canvas), depthTest: false, sizeAttenuation: false}));
  sprite.center.set(26 / 64, 1 - 38 / 64);
  sprite.scale.setScalar(0.09);
  sprite.renderOrder = 3;
  return sprite;
}

export class Candidates {
  private readonly labels: THREE.Sprite[][];  // of each number: not chosen, chosen
  private readonly list = element('candidates');
  private readonly overlay = element<HTMLCanvasElement>('picture-marks');
  private readonly picture = element<HTMLCanvasElement>('picture');
  private cameras: Camera[] = [];
  private shown?: TargetCandidates;
  private newest = -1;  // us, of the target
  private emptied = 0;  // ms
  private text = '';
  private drawn = false;

  constructor(private readonly scene: Scene) {
    this.labels = Array.from({length: kMost}, (_, i) => [false, true].map(chosen => label(String(i + 1), chosen)));
    for (const pair of this.labels) for (const each of pair) {
      each.visible = false;
      scene.overlay.add(each);
    }
  }

  setup({cameras}: Setup) { this.cameras = cameras; }

  show(candidates: TargetCandidates) {
    this.shown = candidates;
    this.newest = Math.max(candidates.utime, this.newest);
  }

  /** The target with this name; of others nothing is shown. */
  target({utime}: Target) { this.newest = utime; }

  /** Of another target, or at another position of a log. */
  clear() {
    this.shown = undefined;
    this.newest = -1;
  }

  /** To be called now and then: draws what has changed. */
  refresh(uncalibrated: boolean) {
    const current = this.shown && Math.abs(this.newest - this.shown.utime) <= kCurrent && this.shown.candidates.length > 0;
    const candidates = current ? this.shown!.candidates.slice(0, kMost) : [];
    this.draw(candidates);
    for (const [i, pair] of this.labels.entries()) {
      for (const [chosen, sprite] of pair.entries()) {
        const candidate = candidates[i];
        const visible = candidate !== undefined && Number(candidate.chosen) === chosen && !uncalibrated;
        if (visible || sprite.visible) this.scene.redraw();
        sprite.visible = visible;
        if (visible) sprite.position.fromArray(candidate.position_m);
      }
    }
    this.describe(candidates);
  }

  private draw(candidates: TargetCandidate[]) {
    if (!candidates.length && !this.drawn) return;
    this.drawn = candidates.length > 0;
    const {clientWidth: width, clientHeight: height} = this.picture;
    if (this.overlay.width !== width || this.overlay.height !== height) [this.overlay.width, this.overlay.height] = [width, height];
    const context = this.overlay.getContext('2d')!;
    context.clearRect(0, 0, width, height);
    for (const [side, camera] of this.cameras.entries()) {
      candidates.forEach((candidate, i) => {
        const [u, v] = side === 0 ? candidate.left_px : candidate.right_px;
        mark(context, (side + (u + 0.5) / camera.width_px) * width / 2, (v + 0.5) / camera.height_px * height, 11, String(i + 1), candidate.chosen);
      });
    }
  }

  private describe(candidates: TargetCandidate[]) {
    const now = performance.now();
    if (candidates.length) this.emptied = now + kLinger;
    else if (now < this.emptied) return;
    const best = candidates[0];
    const lines = candidates.map((candidate, i) =>
      [`${candidate.chosen ? 'chosen' : 'not chosen'}${candidate.chosen || !candidate.reason ? '' : `: ${candidate.reason}`}${i ? ` – ${lessLikely(best.score - candidate.score)}` : ''}`, evidence(candidate, best)]);
    const text = JSON.stringify(lines);
    if (text === this.text) return;
    this.text = text;
    this.list.hidden = !lines.length;
    this.list.replaceChildren(...lines.map(([verdict, why]) => {
      const entry = document.createElement('li'), strong = document.createElement('strong');
      strong.textContent = verdict;
      entry.append(strong, `. ${why[0].toUpperCase()}${why.slice(1)}.`);
      return entry;
    }));
  }
}
