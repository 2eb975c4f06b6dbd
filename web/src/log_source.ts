// Questions about recorded runs to multireach-page (tools/page/log_answers.hpp).
import type {Message} from './messages';

/** A position in a run's log. Times are microseconds since the first event of the recorded log. */
export interface LogPosition {
  event: number; at: number; rates: Record<string, number>;
  pictures: {stereo?: number; pair?: number};  // the newest events with images
}
export interface LogState extends LogPosition { messages: Message[] }
export interface LogStep extends LogPosition { channel: string; number: number; message: unknown }
export interface LogOverview {
  duration_us: number; events: number; channels: Record<string, number>;
  targets: Record<string, [number, number][]>;  // by name: [at, status] where the status changes
}

type Parameters = Record<string, number | string>;

export class LogSource {
  constructor(private readonly token: string) {}

  overview() { return this.ask<LogOverview>('overview', {}); }
  state(parameters: Parameters) { return this.ask<LogState>('state', parameters); }
  span(parameters: Parameters) { return this.ask<LogState>('span', parameters); }
  step(parameters: Parameters) { return this.ask<LogStep>('step', parameters); }

  async picture(parameters: Parameters): Promise<Blob | undefined> {
    const answer = await this.fetch('picture', parameters);
    return answer?.status === 200 ? answer.blob() : undefined;
  }

  /** Nothing when the run is gone, or the server. */
  private async ask<Answer>(question: string, parameters: Parameters): Promise<Answer | undefined> {
    const answer = await this.fetch(question, parameters);
    return answer?.status === 200 ? await answer.json() as Answer : undefined;
  }

  private async fetch(question: string, parameters: Parameters): Promise<Response | undefined> {
    const words = Object.entries(parameters).map(([name, value]) => `&${name}=${value}`).join('');
    try {
      return await fetch(`log/${question}?token=${encodeURIComponent(this.token)}${words}`);
    } catch {
      return undefined;  // the WebSocket tells that the server has gone
    }
  }
}
