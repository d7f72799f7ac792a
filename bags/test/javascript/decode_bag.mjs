// Decodes every message of the MCAP files named on the command line, indexed and in full, and prints what was found as JSON:
// {"messages": {topic: count}, "types": {topic: type}, "sums": {topic: sum of all numbers in all messages}}.
import { readFile } from "node:fs/promises";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import zstd from "@foxglove/wasm-zstd";

await zstd.isLoaded;
const decompressHandlers = { zstd: (data, size) => zstd.decompress(data, Number(size)) };
const found = { messages: {}, types: {}, sums: {} };

function sum(value) {
  if (typeof value === "number") return Number.isFinite(value) ? value : 0;
  if (typeof value === "bigint") return Number(value);
  if (typeof value !== "object" || value === null) return 0;
  let total = 0;
  for (const part of ArrayBuffer.isView(value) || Array.isArray(value) ? value : Object.values(value)) total += sum(part);
  return total;
}

for (const path of process.argv.slice(2)) {
  const bytes = await readFile(path);
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => new Uint8Array(bytes.buffer, bytes.byteOffset + Number(offset), Number(length)),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const readers = new Map();
  for (const channel of reader.channelsById.values()) {
    const schema = reader.schemasById.get(channel.schemaId);
    if (schema.encoding !== "ros2msg" || channel.messageEncoding !== "cdr") throw new Error(`${channel.topic}: encoding`);
    if (!channel.metadata.has("offered_qos_profiles")) throw new Error(`${channel.topic}: no quality of service`);
    const definition = parse(new TextDecoder().decode(schema.data), { ros2: true });
    readers.set(channel.id, { channel, schema, reader: new MessageReader(definition) });
  }
  let indexed = 0;
  for await (const message of reader.readMessages()) {
    const { channel, schema, reader: decoder } = readers.get(message.channelId);
    const decoded = decoder.readMessage(message.data);
    found.messages[channel.topic] = (found.messages[channel.topic] ?? 0) + 1;
    found.types[channel.topic] = schema.name;
    found.sums[channel.topic] = (found.sums[channel.topic] ?? 0) + sum(decoded);
    indexed++;
  }
  const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  stream.append(new Uint8Array(bytes));
  let streamed = 0;
  for (let record; (record = stream.nextRecord()); ) if (record.type === "Message") streamed++;
  if (!stream.done() || streamed !== indexed || BigInt(indexed) !== reader.statistics.messageCount) {
    throw new Error(`${path}: ${indexed} messages by the index, ${streamed} in the stream`);
  }
}
console.log(JSON.stringify(found));
