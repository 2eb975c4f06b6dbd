// The table of nodes.
import type {NodeStatus} from './messages';

const kSilence = 2500;  // ms without NODE_STATUS, which comes once a second
const kColumns = ['received', 'dropped', 'refused', 'late', 'limited', 'sent'] as const;

interface Row { row: HTMLTableRowElement; cells: HTMLTableCellElement[]; heard: number; status: NodeStatus }

export class Nodes {
  private readonly rows = new Map<string, Row>();

  constructor(private readonly body: HTMLElement) {}

  /** `now`: of the clock that `refresh` gets, milliseconds. */
  show(status: NodeStatus, now = performance.now()) {
    const known = this.rows.get(status.node) ?? this.addRow(status);
    known.status = status;
    known.heard = now;
    kColumns.forEach((column, i) => { known.cells[i + 1].textContent = status[column].toLocaleString('en'); });
    for (const column of ['dropped', 'refused'] as const) known.cells[kColumns.indexOf(column) + 1].dataset.problem = String(status[column] > 0);
  }

  /** Says which nodes are silent; to be called now and then. */
  refresh(now = performance.now()) {
    for (const {cells, heard, status} of this.rows.values()) {
      const silence = now - heard;
      const silent = silence > kSilence;
      const text = silent ? `⚠ silent for ${Math.round(silence / 1000)} s (was: ${status.state})` : status.state;
      if (cells[0].textContent !== text) cells[0].textContent = text;
      cells[0].dataset.problem = String(silent);
    }
  }

  private addRow(status: NodeStatus): Row {
    const row = document.createElement('tr');
    const name = document.createElement('th');
    name.scope = 'row';
    name.textContent = status.node;
    const cells = Array.from({length: kColumns.length + 1}, () => document.createElement('td'));
    row.append(name, ...cells);
    const added = {row, cells, heard: 0, status};
    this.rows.set(status.node, added);
    const sorted = [...this.rows.entries()].sort(([a], [b]) => a.localeCompare(b));
    this.body.replaceChildren(...sorted.map(([, each]) => each.row));
    return added;
  }
}
