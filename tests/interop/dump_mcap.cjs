// Prints the messages of an MCAP file, read with the readers of the MCAP project, as JSON: {topic: [message, ...]}.
// Bytes are in hexadecimal digits; a PointCloud2 has its points as its fields say, a row of numbers each.
// node dump_mcap.cjs NODE_MODULES FILE
"use strict";
const fs = require("fs");
const path = require("path");
const [modules, file] = process.argv.slice(2);
const load = require("module").createRequire(path.join(modules, "node_modules", "x.js"));
const { McapStreamReader } = load("@mcap/core");
const { parse } = load("@foxglove/rosmsg");
const { MessageReader } = load("@foxglove/rosmsg2-serialization");

const sizes = { 6: "getUint32", 7: "getFloat32" };

function pointsOf({ fields, data, width, point_step: step }) {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  return Array.from({ length: width }, (_, k) =>
    fields.map(({ offset, datatype }) => view[sizes[datatype]](k * step + offset, true)));
}

const schemas = new Map(), channels = new Map(), messages = {};
const reader = new McapStreamReader();
reader.append(fs.readFileSync(file));
for (let record; (record = reader.nextRecord());) {
  if (record.type === "Schema")
    schemas.set(record.id, new MessageReader(parse(new TextDecoder().decode(record.data), { ros2: true })));
  if (record.type === "Channel") channels.set(record.id, record);
  if (record.type !== "Message") continue;
  const { topic, schemaId } = channels.get(record.channelId);
  const message = schemas.get(schemaId).readMessage(record.data);
  if (message.fields) message.points = pointsOf(message);
  (messages[topic] ??= []).push(message);
}
console.log(JSON.stringify(messages, (_, value) =>
  value instanceof Uint8Array ? Buffer.from(value).toString("hex")
    : ArrayBuffer.isView(value) ? Array.from(value) : value));
