// The time line of a log: pictures of the session, when the target was seen, differences to another run, and the position.
import type {LogOverview, LogSource} from './log_source';

const kPictureHeight = 44, kBand = 9, kAxis = 16, kTop = 12;  // px
const kMostPictures = 24;
const kSteps = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1800, 3600];  // s between labels
const kLabelWidth = 70;  // px

export interface Mark { at: number; text: string }

export class TimeLine {
  private readonly context: CanvasRenderingContext2D;
  private overview?: LogOverview;
  private readonly pictures: {at: number; image: ImageBitmap}[] = [];
  private loaded = 0;  // the width for which there are pictures
  private loading = 0;
  private at = 0;
  private marks: Mark[] = [];

  constructor(private readonly canvas: HTMLCanvasElement, private readonly source: LogSource, private readonly seek: (at: number, done: boolean) => void) {
    this.context = canvas.getContext('2d')!;
    canvas.height = kTop + kPictureHeight + kBand + kAxis;
    canvas.addEventListener('pointerdown', event => {
      canvas.setPointerCapture(event.pointerId);
      this.seek(this.timeAt(event), false);
    });
    canvas.addEventListener('pointermove', event => { if (canvas.hasPointerCapture(event.pointerId)) this.seek(this.timeAt(event), false); });
    canvas.addEventListener('pointerup', event => this.seek(this.timeAt(event), true));
    new ResizeObserver(() => { this.draw(); void this.load(); }).observe(canvas);
  }

  show(overview: LogOverview) {
    this.overview = overview;
    this.canvas.setAttribute('aria-valuemax', (overview.duration_us * 1e-6).toFixed(3));
    this.draw();
    void this.load();
  }

  setMarks(marks: Mark[]) {
    this.marks = marks;
    this.draw();
  }

  setPosition(at: number) {
    this.at = at;
    this.canvas.setAttribute('aria-valuenow', (at * 1e-6).toFixed(3));
    this.canvas.setAttribute('aria-valuetext', `${(at * 1e-6).toFixed(3)} s`);
    this.draw();
  }

  get pictureCount() { return this.pictures.length; }

  private timeAt(event: PointerEvent) {
    const part = (event.offsetX - 1) / Math.max(this.canvas.clientWidth - 2, 1);
    return Math.round(Math.min(Math.max(part, 0), 1) * (this.overview?.duration_us ?? 0));
  }

  private xOf(at: number) { return 1 + at / Math.max(this.overview?.duration_us ?? 1, 1) * (this.canvas.width - 2); }

  /** One picture after the other; begins anew when the width has changed much. */
  private async load() {
    const width = this.canvas.clientWidth;
    if (!this.overview || !width || Math.abs(width - this.loaded) < 0.2 * width) return;
    this.loaded = width;
    const loading = ++this.loading;
    const count = Math.min(Math.ceil(width / (kPictureHeight * 4 / 3)), kMostPictures);
    for (const picture of this.pictures.splice(0)) picture.image.close();
    for (let i = 0; i < count; ++i) {
      const at = Math.round((i + 0.5) / count * this.overview.duration_us);
      const jpeg = await this.source.picture({at, side: 'left', width: 96});
      const image = jpeg && await createImageBitmap(jpeg).catch(() => undefined);
      if (loading !== this.loading) return;
      if (!image) continue;
      this.pictures.push({at, image});
      this.draw();
    }
    this.canvas.dataset.pictures = String(this.pictures.length);
  }

  draw() {
    const {canvas, context, overview} = this;
    const width = canvas.clientWidth;
    if (!width) return;
    if (canvas.width !== width) canvas.width = width;
    const style = getComputedStyle(document.documentElement);
    const colour = (name: string) => style.getPropertyValue(name).trim();
    context.fillStyle = colour('--ground');
    context.fillRect(0, 0, width, canvas.height);
    if (!overview) return;
    const each = width / Math.max(this.pictures.length, 1);
    context.save();
    for (const {at, image} of this.pictures) {
      const drawn = kPictureHeight * image.width / image.height;
      context.beginPath();
      context.rect(this.xOf(at) - each / 2, kTop, each, kPictureHeight);
      context.save();
      context.clip();
      context.drawImage(image, this.xOf(at) - drawn / 2, kTop, drawn, kPictureHeight);
      context.restore();
    }
    context.restore();
    this.drawTarget(colour);
    this.drawAxis(colour);
    for (const [i, mark] of this.marks.entries()) this.drawMark(mark, i, colour);
    context.fillStyle = colour('--accent');
    context.fillRect(Math.round(this.xOf(this.at)) - 1, 0, 3, canvas.height - kAxis);
  }

  /** Seen: filled; coasting: half as high; lost: empty. */
  private drawTarget(colour: (name: string) => string) {
    const {context, overview} = this;
    const changes = Object.values(overview!.targets)[0] ?? [];
    const top = kTop + kPictureHeight + 1;
    changes.forEach(([at, status], i) => {
      const begin = this.xOf(at), end = this.xOf(changes[i + 1]?.[0] ?? overview!.duration_us);
      const height = status === 1 ? kBand - 2 : status === 2 ? (kBand - 2) / 2 : 1;
      context.fillStyle = colour(status === 1 ? '--good' : '--warn');
      context.fillRect(begin, top + kBand - 2 - height, Math.max(end - begin, 1), height);
    });
  }

  private drawAxis(colour: (name: string) => string) {
    const {context, canvas, overview} = this;
    const seconds = overview!.duration_us * 1e-6;
    const step = kSteps.find(each => seconds / each <= canvas.width / kLabelWidth) ?? kSteps[kSteps.length - 1];
    context.fillStyle = colour('--quiet');
    context.font = '11px system-ui, sans-serif';
    for (let i = 0; i * step <= seconds; ++i) {
      const x = this.xOf(i * step * 1e6);
      const text = `${Number((i * step).toFixed(1))} s`;
      context.textAlign = i === 0 ? 'left' : x > canvas.width - kLabelWidth / 2 ? 'right' : 'center';
      context.fillRect(Math.round(x), canvas.height - kAxis, 1, 3);
      context.fillText(text, x, canvas.height - 3);
    }
  }

  private drawMark({at, text}: Mark, i: number, colour: (name: string) => string) {
    const {context, canvas} = this;
    const x = this.xOf(at);
    context.fillStyle = colour('--stop');
    context.beginPath();
    context.moveTo(x - 6, i ? kTop + kPictureHeight : kTop - 2);
    context.lineTo(x + 6, i ? kTop + kPictureHeight : kTop - 2);
    context.lineTo(x, i ? kTop + kPictureHeight - 9 : kTop + 7);
    context.fill();
    context.fillRect(Math.round(x), kTop, 1, kPictureHeight);
    if (i) return;  // only the first one has room for words
    context.font = '11px system-ui, sans-serif';
    context.fillStyle = colour('--text');
    const right = x + 10 + context.measureText(text).width > canvas.width;
    context.textAlign = right ? 'right' : 'left';
    context.fillText(text, right ? x - 9 : x + 9, kTop - 2);
  }
}
