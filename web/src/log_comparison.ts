// What if: runs computed again with other values, and how they differ from the recorded one.
import {element} from './controls';
import type {Run} from './messages';

const kPanel = `
  <form id="what-if-form">
    <div class="fields">
      <label>law <select name="controller.law"><option value="">recorded</option><option>guarded</option><option>paper</option></select></label>
      <label>motion <select name="controller.motion"><option value="">recorded</option><option>reach</option><option>track</option></select></label>
      <label>γ (rad²/m²) <input name="controller.gamma_rad2_m2" size="6" inputmode="decimal" placeholder="recorded"></label>
      <label>α a step <input name="controller.alpha_per_step" size="5" inputmode="decimal" placeholder="recorded"></label>
      <label>β a step <input name="controller.beta_per_step" size="5" inputmode="decimal" placeholder="recorded"></label>
      <label>robot <select name="robot_model"><option value="ideal">ideal</option><option value="sim">physics</option><option value="recorded">recorded</option></select></label>
      <label class="wide">others <textarea id="what-if-keys" rows="1" spellcheck="false" placeholder="KEY = VALUE, one a line" title="as robot.joint_velocity_limits = [2, 2, 2, 2]"></textarea></label>
      <button type="submit" id="recompute">Compute again</button>
    </div>
    <p id="what-if-error" role="alert"></p>
  </form>
  <div class="scroll" tabindex="0" role="group" aria-label="Runs">
    <table>
      <thead><tr><th scope="col">run</th><th scope="col">reached</th><th scope="col">error (mm)</th><th scope="col">settle (s)</th><th scope="col">apart (mm)</th><th scope="col"></th></tr></thead>
      <tbody id="runs"></tbody>
    </table>
  </div>
  <p id="first-difference" class="line" role="status"></p>`;

const number = (value: unknown, digits: number) => typeof value === 'number' ? value.toFixed(digits) : '–';

/** Numbers with six digits, where they differ in these. */
function shortened(values: [string, string]): string[] {
  const short = values.map(value => value !== '' && Number.isFinite(Number(value)) ? String(Number(Number(value).toPrecision(6))) : value);
  return short[0] === short[1] ? values : short;
}

export class Comparison {
  private readonly section: HTMLElement;
  private runs: Run[] = [];
  private selected?: number;
  private asked = false;

  /** `seek`: goes to a time in the log; `select`: shows a run over the recorded one. */
  constructor(private readonly send: (request: object) => boolean, private readonly seek: (at: number) => void, private readonly onSelect: (id?: number) => void) {
    this.section = document.createElement('section');
    this.section.id = 'comparison';
    this.section.hidden = true;
    this.section.className = 'comparison';
    this.section.setAttribute('aria-label', 'What if');
    this.section.innerHTML = kPanel;
    document.querySelector('main')!.append(this.section);
    element('what-if-form').addEventListener('submit', event => {
      event.preventDefault();
      this.recompute();
    });
  }

  get shown() { return !this.section.hidden; }

  toggle(shown = !this.shown) {
    this.section.hidden = !shown;
    document.body.dataset.panel = shown ? 'comparison' : '';
    element('what-if').setAttribute('aria-expanded', String(shown));
  }

  run(id: number | undefined) { return this.runs.find(run => run.id === id); }

  select(id: number | undefined) {
    this.selected = id;
    this.showList();
  }

  show(runs: Run[]) {
    // What the user has asked for is shown as soon recorded there.
    const ready = runs.filter(run => run.id !== 0 && run.state === 'ready' && this.run(run.id)?.state !== 'ready');
    this.runs = runs;
    this.showList();
    if (this.asked && ready.length) {
      this.asked = false;
      this.onSelect(ready[ready.length - 1].id);
    }
  }

  /** An answer of the server to a request. */
  refuse(text: string) { element('what-if-error').textContent = text; }

  private recompute() {
    const form = element<HTMLFormElement>('what-if-form'), fields = new FormData(form);
    const set: string[] = [];
    let model = 'ideal';
    for (const [name, value] of fields.entries()) {
      const text = String(value).trim();
      if (name === 'robot_model') model = text;
      else if (text) set.push(`${name}=${text}`);
    }
    for (const line of element<HTMLTextAreaElement>('what-if-keys').value.split('\n')) {
      const text = line.replace(/#.*/, '').trim();
      if (text) set.push(text.replace(/\s*=\s*/, '='));
    }
    this.refuse('');
    this.asked = this.send({recompute: {set, robot_model: model}});
    if (!this.asked) this.refuse('not sent: there is no connection');
  }

  private showList() {
    const select = element<HTMLSelectElement>('compared');
    const ready = this.runs.filter(run => run.id !== 0 && run.state === 'ready');
    select.replaceChildren(new Option('no other run', ''), ...ready.map(run => new Option(run.label, String(run.id))));
    select.value = this.selected === undefined ? '' : String(this.selected);
    element('runs').replaceChildren(...this.runs.map(run => this.row(run)));
    this.showDifference();
  }

  private row(run: Run): HTMLTableRowElement {
    const row = document.createElement('tr');
    row.dataset.state = run.state;
    const name = document.createElement('th');
    name.scope = 'row';
    name.title = run.label;
    name.textContent = (run.id === 0 ? 'recorded: ' : run.id === this.selected ? '▦ ' : '') + run.label;
    row.append(name);
    const cell = (text: string) => {
      const added = document.createElement('td');
      added.textContent = text;
      row.append(added);
      return added;
    };
    if (run.state === 'failed') {
      cell(`⚠ ${run.failure}`).colSpan = 4;
    } else if (!run.figures) {
      cell(`${run.doing || 'waiting'} ${Math.round(100 * run.progress)} %`).colSpan = 4;
    } else {
      const figures = run.figures;
      cell(`${figures.reached} of ${figures.reaches}`);
      cell(`${number(figures.hand_error_mm_p50, 2)}, at most ${number(figures.hand_error_mm_max, 2)}`).title = 'median and largest of all reaches';
      cell(`${number(figures.settle_s_p50, 2)}, at most ${number(figures.settle_s_max, 2)}`).title = 'median and largest of all reaches';
      cell(run.comparison ? (1e3 * run.comparison.hand_distance_m).toFixed(1) : '').title = 'the hands, at most';
    }
    const actions = cell('');
    if (run.id === 0) return row;
    if (run.state === 'ready') actions.append(this.button(run.id === this.selected ? 'hide' : 'show', run.label, () => this.onSelect(run.id === this.selected ? undefined : run.id)));
    actions.append(this.button(run.state === 'ready' || run.state === 'failed' ? 'remove' : 'cancel', run.label, () => this.send({remove_run: run.id})));
    return row;
  }

  private button(text: string, label: string, action: () => void) {
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = text;
    button.setAttribute('aria-label', `${text} ${label}`);
    button.addEventListener('click', action);
    return button;
  }

  private showDifference() {
    const line = element('first-difference');
    line.replaceChildren();
    const comparison = this.run(this.selected)?.comparison;
    if (!comparison) return;
    if (!comparison.first) {
      line.textContent = comparison.compared ? `No difference in ${comparison.compared.toLocaleString('en')} messages of the same time.` : 'The runs have no messages of the same time.';
      return;
    }
    const {channel, name, field, at_us} = comparison.first;
    const values = shortened(comparison.first.values);
    line.append(`First difference at ${(1e-6 * at_us).toFixed(3)} s: ${channel}${name ? ` of ${name}` : ''}, ${field}: ${values[0]}, in the compared run ${values[1]}. `,
      this.button('go there', 'First difference:', () => this.seek(at_us)), ' ',
      this.button('hands furthest apart', '', () => this.seek(comparison.hand_at_us)));
  }
}
