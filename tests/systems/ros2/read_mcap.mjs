// Reads an MCAP file by Foxglove's readers, through its index, and checks checksums and messages.
// usage: read_mcap.mjs NODE_MODULES FILE
import { createRequire } from "node:module";
import { open } from "node:fs/promises";
import assert from "node:assert";

const [modules, path] = process.argv.slice(2);
const require = createRequire(modules + "/");
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

const file = await open(path);
const { size } = await file.stat();
const read = async (offset, length) => {
  const bytes = new Uint8Array(Number(length));
  const { bytesRead } = await file.read(bytes, 0, Number(length), Number(offset));
  assert.equal(bytesRead, Number(length));
  return bytes;
};
const reader = await McapIndexedReader.Initialize({ readable: { size: async () => BigInt(size), read } });
assert.equal(reader.header.profile, "ros2");
assert(reader.chunkIndexes.length > 0);

const readers = new Map();
const count = {};
let last = 0n, joints, frames;
for await (const message of reader.readMessages()) {  // validates the checksums of the chunks
  const channel = reader.channelsById.get(message.channelId);
  const schema = reader.schemasById.get(channel.schemaId);
  assert.equal(channel.messageEncoding, "cdr");
  assert.equal(schema.encoding, "ros2msg");
  if (!readers.has(channel.id))
    readers.set(channel.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
  const value = readers.get(channel.id).readMessage(message.data);
  assert(message.logTime >= last);
  last = message.logTime;
  count[channel.topic] = (count[channel.topic] ?? 0) + 1;
  if (channel.topic === "/joint_states") joints = value;
  if (channel.topic === "/tf") frames = value;
  if (value.header && value.header.stamp)
    assert(Math.abs(value.header.stamp.sec + (value.header.stamp.nanosec ?? value.header.stamp.nsec) / 1e9 - Number(message.logTime) / 1e9) < 1e-6);
}
assert.equal(joints.name.length, 12);
assert.equal(joints.position.length, 12);
assert(joints.effort.every(Number.isFinite));
assert.equal(frames.transforms[0].header.frame_id, "odom");
const { x, y, z, w } = frames.transforms[0].transform.rotation;
assert(Math.abs(x * x + y * y + z * z + w * w - 1) < 1e-9);
let total = 0;
for (const [topic, number] of Object.entries(count)) {
  const channel = [...reader.channelsById.values()].find((each) => each.topic === topic);
  assert.equal(BigInt(number), reader.statistics.channelMessageCounts.get(channel.id));
  total += number;
}
assert.equal(BigInt(total), reader.statistics.messageCount);

const stream = new McapStreamReader({ validateCrcs: true });  // checks those of the file as a whole
stream.append(await read(0, size));
let streamed = 0;
for (let record; (record = stream.nextRecord()) !== undefined; ) if (record.type === "Message") ++streamed;
assert(stream.done());
assert.equal(streamed, total);
console.log(`${total} messages of ${Object.keys(count).length} topics:`, JSON.stringify(count));
