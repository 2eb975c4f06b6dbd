// Reads an MCAP file as Foxglove does, by its indexes, and again as a stream; prints counts of messages by topic and schema.
import {McapIndexedReader, McapStreamReader} from '@mcap/core';
import fs from 'node:fs/promises';

const file = await fs.readFile(process.argv[2]);
const readable = {
  size: async () => BigInt(file.length),
  read: async (offset, length) => file.subarray(Number(offset), Number(offset + length)),
};
const indexed = await McapIndexedReader.Initialize({readable});
const topics = {};
let messages = 0;
let last = 0n;
for await (const message of indexed.readMessages()) {
  const channel = indexed.channelsById.get(message.channelId);
  const schema = indexed.schemasById.get(channel.schemaId);
  const value = JSON.parse(new TextDecoder().decode(message.data));
  const described = JSON.parse(new TextDecoder().decode(schema.data));
  for (const key of Object.keys(value)) {
    if (!(key in described.properties)) throw new Error(`${channel.topic}: ${key} is not in the schema`);
  }
  if (message.logTime < last) throw new Error('out of order');
  last = message.logTime;
  const name = `${channel.topic} ${schema.name}`;
  topics[name] = (topics[name] ?? 0) + 1;
  ++messages;
}
const stream = new McapStreamReader();
stream.append(file);
let streamed = 0;
for (let record = stream.nextRecord(); record; record = stream.nextRecord()) streamed += record.type === 'Message';
if (!stream.done() || streamed !== messages || indexed.statistics.messageCount !== BigInt(messages)) {
  throw new Error(`${messages} messages by the indexes, ${streamed} in the stream, ${indexed.statistics.messageCount} by the statistics`);
}
for (const [name, count] of Object.entries(topics).sort()) console.log(name, count);
