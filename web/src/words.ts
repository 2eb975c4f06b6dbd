// The words for the numbers in messages, from the definitions of the messages.
import bridgeState from '../../lcmtypes/bridge_state_t.lcm?raw';
import controllerState from '../../lcmtypes/controller_state_t.lcm?raw';
import target from '../../lcmtypes/target_t.lcm?raw';

/** The constants of a definition that begin with `prefix`, as words: MODE_REACHING is "reaching". */
function words(definition: string, prefix: string): Map<number, string> {
  const found = new Map<number, string>();
  for (const [, name, value] of definition.matchAll(/const\s+int8_t\s+(\w+)\s*=\s*(-?\d+)\s*;/g)) {
    if (name.startsWith(prefix)) found.set(Number(value), name.slice(prefix.length).toLowerCase().replaceAll('_', ' '));
  }
  if (found.size === 0) throw new Error(`no constants ${prefix}* in the definition of a message`);
  return found;
}

const tables = {
  bridge: words(bridgeState, ''),
  mode: words(controllerState, 'MODE_'),
  blocked: words(controllerState, 'BLOCKED_'),
  target: words(target, 'STATUS_'),
};

export function word(table: keyof typeof tables, value: number): string {
  return tables[table].get(value) ?? `unknown (${value})`;
}
