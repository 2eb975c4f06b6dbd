// The page of a log: position, playing, stepping; what is shown of it goes through the same views as live messages.
import './log.css';
import {Comparison} from './log_comparison';
import {addressedView, type Connection} from './connection';
import {element} from './controls';
import {LogSource, type LogOverview, type LogPosition, type LogStep} from './log_source';
import {TimeLine} from './log_timeline';
import type {Answer, Frame, Run} from './messages';
import type {Pictures} from './pictures';
import type {PlotPanel} from './plot_panel';
import {kPlotSpan} from './plots';
import type {Scene} from './scene';

/** The views that a log shares with a running system. */
export interface Views {
  connection: Connection; scene: Scene; pictures: Pictures; plots: PlotPanel; contours: HTMLInputElement;
  show(frame: Frame): void;
}

const kSpeeds = [0.1, 0.25, 0.5, 1, 2, 5, 10, 30, 100];
const kFrame = 40000;  // us: newest messages are shown so often, as live
const kMostSteps = 8;  // of each channel in one answer, when playing fast
const kWindowStep = 80000;  // us between samples when plots are filled anew
const kKeySeek = 1e6;  // us, by the arrow keys on the time line

const kPanel = `
  <div class="bar">
    <button id="play" type="button" aria-keyshortcuts="Space">▶ Play <kbd>space</kbd></button>
    <label>speed <select id="play-speed">${kSpeeds.map(speed => `<option value="${speed}"${speed === 1 ? ' selected' : ''}>${speed} ×</option>`).join('')}</select></label>
    <button id="step-back" type="button" aria-keyshortcuts=",">◀ step <kbd>,</kbd></button>
    <button id="step" type="button" aria-keyshortcuts=".">step ▶ <kbd>.</kbd></button>
    <label>of <select id="step-channel"><option value="">all messages</option></select></label>
    <output id="log-position">reading the log</output>
    <span class="rest"></span>
    <label>compare with <select id="compared"><option value="">no other run</option></select></label>
    <button id="what-if" type="button" aria-expanded="false" aria-controls="comparison">What if … <kbd>W</kbd></button>
    <button id="copy-link" type="button" aria-keyshortcuts="L">Copy link <kbd>L</kbd></button>
  </div>
  <canvas id="time-line" tabindex="0" role="slider" aria-label="Time in the log; arrow keys move by a second" aria-valuemin="0" aria-valuenow="0" aria-valuemax="0"></canvas>
  <p id="stepped" class="line">Step through messages by , and . to see what they say.</p>`;

export class LogMode {
  private readonly source: LogSource;
  private readonly line: TimeLine;
  private readonly comparison: Comparison;
  private overview?: LogOverview;
  private at = 0;
  private event = 0;
  private playing = false;
  private wanted?: {parameters: Record<string, number>; refill: boolean};
  private busy = false;
  private playedAt = 0;  // ms
  private stepping = Promise.resolve();
  private compared?: number;  // run that is shown over the recorded one
  private shownPicture = '';
  private pictureBusy = false;
  private computing = false;  // what the page's address asks for
  private newestPosition?: LogPosition;

  constructor(name: string, private readonly views: Views) {
    document.body.dataset.mode = 'log';
    this.source = new LogSource(views.connection.token);
    const section = document.createElement('section');
    section.className = 'time';
    section.setAttribute('aria-label', `Log ${name}`);
    section.innerHTML = kPanel;
    document.querySelector('main')!.before(section);
    element('answer').textContent = `Log ${name}: there is no robot to command.`;
    this.line = new TimeLine(element<HTMLCanvasElement>('time-line'), this.source, (at, done) => { this.pause(); this.seek({at}, done); });
    this.comparison = new Comparison(request => views.connection.send(request), at => { this.pause(); this.seek({at}, true); }, id => this.compare(id));
    this.listen();
    void this.open();
  }

  /** The clock of the log, milliseconds. */
  get nowMs() { return 1e-3 * this.at; }
  draw() { this.line.draw(); }

  answer({accepted, text}: Answer) { if (!accepted) this.comparison.refuse(text); }

  showRuns(runs: Run[]) {
    this.comparison.show(runs);
    this.showMarks();
    const shown = runs.find(run => run.id === this.compared);
    if (this.compared !== undefined && !shown) this.compare(undefined);
    this.openAddressedRun(runs);
  }

  private async open() {
    this.overview = await this.source.overview();
    if (!this.overview) return;
    const channels = Object.entries(this.overview.channels).sort(([a], [b]) => a.localeCompare(b));
    element<HTMLSelectElement>('step-channel').append(...channels.map(([channel, count]) => new Option(`${channel.toLowerCase().replaceAll('_', ' ')} (${count.toLocaleString('en')})`, channel)));
    this.line.show(this.overview);
    this.views.contours.parentElement!.hidden = !('VISION_DEBUG' in this.overview.channels);
    element('nodes').closest('section')!.dataset.empty = String(!('NODE_STATUS' in this.overview.channels));
    const event = Number(addressedView.get('event') ?? NaN), pose = addressedView.get('camera'), plots = addressedView.get('plots');
    if (pose) this.views.scene.pose = pose.split(',').map(Number);
    if (plots) this.views.plots.choose(plots.split(','));
    if (addressedView.get('panel') === 'comparison') this.comparison.toggle(true);
    this.seek(Number.isInteger(event) ? {event} : {at: 0}, true);
  }

  /** Shows the run that the page's address names, computing it where that has not been done. */
  private openAddressedRun(runs: Run[]) {
    const wanted = addressedView.get('compared');
    if (wanted === null || runs.length === 0) return;
    const description = JSON.parse(wanted) as {label: string; set: string[]; robot_model: string};
    const same = runs.find(run => run.id !== 0 && run.label === description.label && run.robot_model === description.robot_model);
    if (same?.state === 'ready') {
      addressedView.delete('compared');
      this.compare(same.id);
    } else if (!same && description.robot_model) {
      if (this.computing) return;
      this.computing = true;
      this.views.connection.send({recompute: {set: description.set, robot_model: description.robot_model}});
    }
  }

  private listen() {
    element('play').addEventListener('click', () => this.toggle());
    element('step').addEventListener('click', () => this.stepBy(1));
    element('step-back').addEventListener('click', () => this.stepBy(-1));
    element('copy-link').addEventListener('click', () => void this.copyLink());
    element('what-if').addEventListener('click', () => this.comparison.toggle());
    const compared = element<HTMLSelectElement>('compared');
    compared.addEventListener('change', () => this.compare(compared.value ? Number(compared.value) : undefined));
    this.views.contours.addEventListener('change', () => { this.shownPicture = ''; void this.showPicture(); });
    element('time-line').addEventListener('keydown', event => this.lineKey(event));
    // Before any element sees it, so that space plays wherever the focus is, except where text is typed.
    addEventListener('keydown', event => this.key(event), {capture: true});
    addEventListener('keyup', event => { if (event.code === 'Space' && !isTyping(event)) event.preventDefault(); }, {capture: true});
    requestAnimationFrame(now => this.play(now));
  }

  private key(event: KeyboardEvent) {
    if (event.ctrlKey || event.altKey || event.metaKey || isTyping(event)) return;
    const actions: Record<string, () => void> = {
      ' ': () => this.toggle(), ',': () => this.stepBy(-1), '.': () => this.stepBy(1), w: () => this.comparison.toggle(), l: () => void this.copyLink(),
    };
    const action = actions[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    action();
  }

  private lineKey(event: KeyboardEvent) {
    const duration = this.overview?.duration_us ?? 0;
    const to: Record<string, number> = {
      ArrowLeft: this.at - kKeySeek, ArrowRight: this.at + kKeySeek, PageDown: this.at - 10 * kKeySeek, PageUp: this.at + 10 * kKeySeek, Home: 0, End: duration,
    };
    if (!(event.key in to)) return;
    event.preventDefault();
    this.pause();
    this.seek({at: Math.round(Math.min(Math.max(to[event.key], 0), duration))}, true);
  }

  private toggle() {
    if (this.playing) return this.pause();
    if (this.overview && this.at >= this.overview.duration_us) this.seek({at: 0}, true);
    this.playing = true;
    this.playedAt = performance.now();
    this.showButton();
  }

  private pause() {
    this.playing = false;
    this.showButton();
  }

  private showButton() {
    const button = element('play');
    button.firstChild!.textContent = this.playing ? 'Ⅱ Pause ' : '▶ Play ';
    button.dataset.playing = String(this.playing);
  }

  /** `done`: the plots and the trail are filled, too; while the user moves along the time line, they would lag. */
  private seek(parameters: Record<string, number>, done: boolean) {
    this.wanted = {parameters, refill: done};
    void this.pump();
  }

  /** One question at a time: what was asked for meanwhile is answered next, and only the newest. */
  private async pump() {
    if (this.busy) return;
    this.busy = true;
    while (this.wanted) {
      const {parameters, refill} = this.wanted;
      this.wanted = undefined;
      const state = await this.source.state(parameters);
      if (!state) break;
      const other = await this.other(id => this.source.state({run: id, at: state.at}));
      this.arrive(state);
      if (refill) {
        const window = {after: state.at - 1e6 * kPlotSpan, until: state.at, step: kWindowStep};
        const [ours, theirs] = await Promise.all([this.source.span(window), this.other(id => this.source.span({...window, run: id}))]);
        // Later messages of the same time do not belong to it.
        if (ours) this.views.show({utime: 0, messages: ours.messages, history: 'only', begins: true});
        if (theirs) this.views.show({utime: 0, messages: theirs.messages, history: 'only', compared: true});
      }
      this.views.show({utime: 0, messages: state.messages, history: 'none'});
      if (other) this.views.show({utime: 0, messages: other.messages, history: 'none', compared: true});
      document.documentElement.dataset.shownEvent = String(state.event);
    }
    this.busy = false;
  }

  private play(now: number) {
    requestAnimationFrame(next => this.play(next));
    if (!this.playing || this.busy || !this.overview) return;
    const speed = Number(element<HTMLSelectElement>('play-speed').value);
    const until = Math.min(this.at + Math.round(1e3 * (now - this.playedAt) * speed), this.overview.duration_us);
    if (until - this.at < kFrame * Math.min(speed, 1) && until < this.overview.duration_us) return;
    this.playedAt = now;
    void this.playUntil(until);
  }

  private async playUntil(until: number) {
    this.busy = true;
    const span = {after: this.at, until, step: Math.max(kFrame, Math.ceil((until - this.at) / kMostSteps))};
    const [ours, theirs] = await Promise.all([this.source.span(span), this.other(id => this.source.span({...span, run: id}))]);
    this.busy = false;
    if (this.wanted) return void this.pump();
    if (!ours || !this.playing) return;
    this.arrive({...ours, at: until});
    this.views.show({utime: 0, messages: ours.messages});
    if (theirs) this.views.show({utime: 0, messages: theirs.messages, compared: true});
    if (until >= this.overview!.duration_us) this.pause();
  }

  private async other<Answer>(ask: (id: number) => Promise<Answer>): Promise<Answer | undefined> {
    return this.compared === undefined ? undefined : ask(this.compared);
  }

  /** One step after the other, however fast the key is pressed. */
  private stepBy(by: number) { this.stepping = this.stepping.then(() => this.step(by)); }

  private async step(by: number) {
    this.pause();
    const channel = element<HTMLSelectElement>('step-channel').value;
    const step = await this.source.step({event: this.event, by, ...(channel ? {channel} : {})});
    if (!step) return;
    this.showStep(step);
    this.event = step.event;
    this.seek({event: step.event}, true);
  }

  private showStep({channel, number, message}: LogStep) {
    const text = `event ${number} · ${channel} ${typeof message === 'string' ? message : JSON.stringify(message).replaceAll('"', '').replaceAll(',', ', ').replaceAll(':', ' ')}`;
    const line = element('stepped');
    line.textContent = line.title = text;
  }

  private arrive(position: LogPosition) {
    this.at = position.at;
    this.event = position.event;
    this.newestPosition = position;
    this.line.setPosition(position.at);
    element('log-position').textContent = `${(1e-6 * position.at).toFixed(3)} of ${(1e-6 * this.overview!.duration_us).toFixed(3)} s · event ${position.event.toLocaleString('en')}`;
    element('rates').textContent = `a second: ${Object.entries(position.rates).map(([channel, rate]) => `${channel.toLowerCase().replaceAll('_', ' ')} ${rate}`).join(' · ')}`;
    void this.showPicture();
  }

  /** Both images of the newest pair, or what vision drew of it; one after the other, and only the newest. */
  private async showPicture() {
    if (this.pictureBusy) return;
    this.pictureBusy = true;
    while (this.newestPosition) {
      const {stereo, pair} = this.newestPosition.pictures;
      const drawn = this.views.contours.checked && pair !== undefined;
      const wanted = drawn ? `pair ${pair}` : `stereo ${stereo}`;
      if (wanted === this.shownPicture || (!drawn && stereo === undefined)) break;
      this.shownPicture = wanted;
      const sides = drawn ? ['pair'] as const : ['left', 'right'] as const;
      const jpegs = await Promise.all(sides.map(side => this.source.picture({event: drawn ? pair : stereo!, side})));
      for (const [i, jpeg] of jpegs.entries()) if (jpeg) await this.views.pictures.show({side: sides[i], jpeg});
    }
    this.pictureBusy = false;
  }

  private compare(id: number | undefined) {
    this.compared = id;
    this.comparison.select(id);
    if (id === undefined) this.views.scene.setCompared();
    this.showMarks();
    this.seek({event: this.event}, true);
  }

  private showMarks() {
    const comparison = this.comparison.run(this.compared)?.comparison;
    const marks = [];
    if (comparison?.first) {
      const {channel, field, at_us} = comparison.first;
      marks.push({at: at_us, text: `first difference: ${channel} ${field}`});
      if (comparison.hand_distance_m > 0) marks.push({at: comparison.hand_at_us, text: 'hands furthest apart'});
    }
    this.line.setMarks(marks);
  }

  /** Of this exact view: position, camera, plots, panel, and the run that is compared. It holds the token. */
  private async copyLink() {
    const view = new URLSearchParams({event: String(this.event), camera: this.views.scene.pose.map(number => number.toFixed(4)).join(','), plots: this.views.plots.names.join(',')});
    if (this.comparison.shown) view.set('panel', 'comparison');
    const run = this.comparison.run(this.compared);
    if (run) view.set('compared', JSON.stringify({label: run.label, set: run.set, robot_model: run.robot_model}));
    const link = `${location.origin}${location.pathname}#${this.views.connection.token}&${view}`;
    const line = element('answer');
    try {
      await navigator.clipboard.writeText(link);
      line.textContent = 'The link to this view is in the clipboard. It holds the token of this page: whoever has it can use the page.';
    } catch {
      line.textContent = `The browser does not allow access to the clipboard; the link: ${link}`;
    }
    line.dataset.link = link;
  }
}

function isTyping(event: KeyboardEvent): boolean {
  const target = event.target;
  return target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && !['checkbox', 'radio', 'range', 'button'].includes(target.type));
}
