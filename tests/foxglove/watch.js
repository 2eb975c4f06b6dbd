// Connects to a page as Foxglove does, subscribes to all topics, and prints how many messages of each arrive within some seconds. Messages
// of Foxglove's own types must fit the schemas that Foxglove publishes.
//   node watch.js ws://HOST:PORT/foxglove?token=TOKEN SECONDS
import * as published from '@foxglove/schemas/jsonschema.js';
import ws from '@foxglove/ws-protocol';
import Ajv from 'ajv';
import {WebSocket} from 'ws';

const {FoxgloveClient} = ws;
const [address, seconds] = process.argv.slice(2);
const client = new FoxgloveClient({ws: new WebSocket(address, [FoxgloveClient.SUPPORTED_SUBPROTOCOL])});
const topics = new Map();
const ajv = new Ajv({strict: false});
/** What refuses messages that do not fit; nothing for types that are not Foxglove's. */
const judge = name => name.startsWith('foxglove.') ? ajv.compile((published.default ?? published)[name.slice('foxglove.'.length)]) : undefined;
client.on('error', error => { console.error(String(error.message ?? error)); process.exit(1); });
client.on('serverInfo', info => console.log(`server ${info.name}`));
client.on('advertise', channels => {
  for (const channel of channels) {
    const schema = JSON.parse(channel.schema);
    topics.set(client.subscribe(channel.id), {name: `${channel.topic} ${channel.schemaName}`, keys: Object.keys(schema.properties), fits: judge(channel.schemaName), count: 0});
  }
});
client.on('message', ({subscriptionId, timestamp, data}) => {
  const topic = topics.get(subscriptionId);
  const message = JSON.parse(new TextDecoder().decode(data));
  for (const key of Object.keys(message)) if (!topic.keys.includes(key)) throw new Error(`${topic.name}: ${key} is not in the schema`);
  if (topic.fits && !topic.fits(message)) throw new Error(`${topic.name}: ${ajv.errorsText(topic.fits.errors)}`);
  if (Math.abs(Number(timestamp / 1000000n) - Date.now()) > 10000) throw new Error(`${topic.name}: ${timestamp} is not now`);
  ++topic.count;
});
setTimeout(() => {
  for (const {name, count} of topics.values()) console.log(name, count);
  process.exit(0);
}, 1000 * Number(seconds));
