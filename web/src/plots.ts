// Plots of the last seconds. Series differ by colour and by dash, in the colours of Okabe and Ito.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import type {Joint} from './messages';

const kColours = ['#0072b2', '#d55e00', '#009e73', '#b0408a', '#56b4e9', '#b8860b', '#7a7a7a'];
const kDashes = [[], [8, 3], [2, 3], [8, 3, 2, 3]];
const kSpan = 20;  // s
const kMostPoints = 25 * kSpan;
export const kPlotSpan = kSpan;

export const colourOf = (i: number) => kColours[i % kColours.length];
export const dashOf = (i: number) => kDashes[i % kDashes.length];

interface Theme { text: string; line: string }

export class Plot {
  private plot?: uPlot;
  private readonly data: (number | null)[][];
  private readonly compared: (number | null)[][];  // of another run, drawn over it
  readonly figure: HTMLElement;
  private readonly holder: HTMLDivElement;
  dirty = true;

  /** `levels`: values that are marked by lines, as limits. */
  constructor(parent: HTMLElement, title: string, series: number, private readonly levels: number[], private readonly floor?: [number, number]) {
    this.data = Array.from({length: series + 1}, () => []);
    this.compared = Array.from({length: series + 1}, () => []);
    const figure = document.createElement('figure');
    const caption = document.createElement('figcaption');
    caption.textContent = title;
    this.holder = document.createElement('div');
    figure.append(caption, this.holder);
    parent.append(figure);
    this.figure = figure;
    new ResizeObserver(() => {
      const {clientWidth: width, clientHeight: height} = this.holder;
      if (width && height) this.plot?.setSize({width, height});
    }).observe(this.holder);
  }

  add(time: number, values: (number | null)[]) { this.addTo(this.data, time, values); }
  addCompared(time: number, values: (number | null)[]) { this.addTo(this.compared, time, values); }

  clear() {
    for (const column of [...this.data, ...this.compared]) column.length = 0;
    this.dirty = true;
  }

  private addTo(columns: (number | null)[][], time: number, values: (number | null)[]) {
    const times = columns[0] as number[];
    if (times.length && time <= times[times.length - 1]) {
      if (time > times[times.length - 1] - 1) return;
      for (const column of columns) column.length = 0;  // the clock of another run
    }
    [time, ...values].forEach((value, i) => columns[i]?.push(value));
    while (times.length > kMostPoints || times[0] < time - kSpan) for (const column of columns) column.shift();
    this.dirty = true;
  }

  draw() {
    if (!this.dirty || !this.plot || this.figure.hidden) return;
    this.dirty = false;
    this.plot.setData(this.data as uPlot.AlignedData);
  }

  setTheme(theme: Theme) {
    this.plot?.destroy();
    this.plot = new uPlot(this.options(theme), this.data as uPlot.AlignedData, this.holder);
    this.dirty = true;
  }

  private options(theme: Theme): uPlot.Options {
    const axis = {stroke: theme.text, grid: {stroke: theme.line, width: 1}, ticks: {show: false}, font: '11px system-ui, sans-serif'};
    const [least, most] = this.floor ?? [0, 0];
    return {
      width: Math.max(this.holder.clientWidth, 50), height: Math.max(this.holder.clientHeight, 40),
      legend: {show: false}, cursor: {show: false}, select: {show: false, left: 0, top: 0, width: 0, height: 0},
      padding: [6, 8, 0, 0],
      scales: {
        x: {time: false, range: (_, __, max) => [max - kSpan, max]},
        y: {range: (_, min, max) => this.range(min ?? least, max ?? most)},
      },
      axes: [
        {
          ...axis, size: 18, gap: 2,
          splits: self => [20, 15, 10, 5, 0].map(ago => (self.scales.x.max ?? 0) - ago),
          values: () => ['', '-15 s', '-10 s', '-5 s', ''],
        },
        {...axis, size: 44, gap: 3},
      ],
      series: [{}, ...this.data.slice(1).map((_, i) => ({stroke: colourOf(i), dash: dashOf(i), width: 1.5, points: {show: false}}))],
      hooks: {draw: [self => this.drawLevels(self, theme), self => this.drawCompared(self, theme)]},
    };
  }

  private range(min: number, max: number): [number, number] {
    const [least, most] = this.floor ?? [min, max];
    const others = this.compared.slice(1).flat().filter((value): value is number => value !== null);
    const low = Math.min(min, least, ...others), high = Math.max(max, most, ...others);
    const margin = 0.06 * (high - low || 1);
    return [low - margin, high + margin];
  }

  private drawLevels(self: uPlot, theme: Theme) {
    const {ctx, bbox} = self;
    ctx.save();
    ctx.strokeStyle = theme.text;
    ctx.setLineDash([4, 4]);
    for (const level of this.levels) {
      const y = Math.round(self.valToPos(level, 'y', true)) + 0.5;
      if (y < bbox.top || y > bbox.top + bbox.height) continue;
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
    }
    ctx.restore();
  }

  /** Thin and dotted, in the colour of the text. */
  private drawCompared(self: uPlot, theme: Theme) {
    const {ctx, bbox} = self;
    const times = this.compared[0] as number[];
    if (!times.length) return;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.strokeStyle = theme.text;
    ctx.lineWidth = 1;
    ctx.setLineDash([2, 2]);
    ctx.beginPath();
    for (const column of this.compared.slice(1)) {
      let begun = false;
      column.forEach((value, i) => {
        if (value === null) { begun = false; return; }
        const x = self.valToPos(times[i], 'x', true), y = self.valToPos(value, 'y', true);
        if (begun) ctx.lineTo(x, y);
        else ctx.moveTo(x, y);
        begun = true;
      });
    }
    ctx.stroke();
    ctx.restore();
  }
}

/** A list entry for each joint, with a sample of its line. */
export function jointLegend(list: HTMLElement, joints: Joint[]) {
  list.replaceChildren(...joints.map((joint, i) => {
    const entry = document.createElement('li');
    entry.innerHTML = `<svg width="26" height="8" aria-hidden="true"><line x1="0" x2="26" y1="4" y2="4" stroke="${colourOf(i)}" stroke-width="2.5" stroke-dasharray="${dashOf(i).join(' ')}"/></svg>`;
    entry.append(joint.name);
    return entry;
  }));
}
