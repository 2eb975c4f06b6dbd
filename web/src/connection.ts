// The WebSocket to multireach-page, opened again when it closes.
import type {Answer, Frame, Picture, Run, Setup} from './messages';

export interface Receiver {
  setup(setup: Setup): void;
  frame(frame: Frame): void;
  answer(answer: Answer): void;
  picture(picture: Picture): void;
  runs(runs: Run[]): void;
  /** `problem`: why there is no connection, in words; nothing while there is one. */
  connected(problem?: string): void;
}

const kRetry = 1000;  // ms
const kSides: Record<number, Picture['side']> = {2: 'left', 3: 'right', 4: 'pair'};  // Outgoing::Kind

/** What the page's address says besides the token: a view of a log. */
export let addressedView = new URLSearchParams();

/** The token of the page's address, kept for this tab so that the address can be cleaned. */
function token(): string {
  if (location.hash.length > 1) {
    const [secret, ...view] = location.hash.slice(1).split('&');
    sessionStorage.setItem('token', secret);
    addressedView = new URLSearchParams(view.join('&'));
    history.replaceState(null, '', location.pathname);
  }
  return sessionStorage.getItem('token') ?? '';
}

export class Connection {
  private socket?: WebSocket;
  readonly token = token();

  private decoding = 0;  // ms

  constructor(private readonly receiver: Receiver) { this.open(); }

  /** Returns false when there is no connection. */
  send(request: object): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(request));
    return true;
  }

  /** Milliseconds spent on reading messages since the last call. */
  takeDecoding(): number {
    const decoding = this.decoding;
    this.decoding = 0;
    return decoding;
  }

  private open() {
    if (!this.token) {
      this.receiver.connected('this address lacks its token: open the address that multireach-page printed');
      return;
    }
    const socket = new WebSocket(`ws://${location.host}/messages?token=${encodeURIComponent(this.token)}`);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => this.receiver.connected();
    socket.onmessage = event => this.receive(event.data);
    socket.onclose = () => {
      this.receiver.connected('no connection; has the run ended?');
      setTimeout(() => this.open(), kRetry);
    };
    this.socket = socket;
  }

  private receive(data: string | ArrayBuffer) {
    if (typeof data !== 'string') {
      const side = kSides[new Uint8Array(data, 0, 1)[0]];
      if (side) this.receiver.picture({side, jpeg: new Blob([new Uint8Array(data, 1)], {type: 'image/jpeg'})});
      return;
    }
    const begin = performance.now();
    const message = JSON.parse(data);
    this.decoding += performance.now() - begin;
    if (message.setup) this.receiver.setup(message.setup);
    else if (message.answer) this.receiver.answer(message);
    else if (message.runs) this.receiver.runs(message.runs);
    else if (message.messages) this.receiver.frame(message);
  }
}
