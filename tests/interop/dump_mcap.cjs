// Prints the messages of an MCAP file, read with the readers of the MCAP project, as JSON: {topic: [message,
// ...]}. Bytes are printed in hexadecimal. The points of a PointCloud2 are decoded using its fields, one row
// of numbers per point. node dump_mcap.cjs NODE_MODULES FILE
'use strict';
const assert = require('assert');
const fs = require('fs');
const path = require('path');
const [modules, file] = process.argv.slice(2);
const load = require('module').createRequire(path.join(modules, 'node_modules', 'x.js'));
const {McapIndexedReader} = load('@mcap/core');
const {parse} = load('@foxglove/rosmsg');
const {MessageReader} = load('@foxglove/rosmsg2-serialization');

const bytes = fs.readFileSync(file);
const readable = {
  size: async () => BigInt(bytes.length),
  read: async (offset, length) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + length)))
};
const sizes = {2: 'getUint8', 6: 'getUint32', 7: 'getFloat32'};

function pointsOf({fields, data, width, point_step: step}) {
  assert.equal(data.length, width * step);
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  return Array.from({length: width}, (_, k) =>
    fields.map(({offset, datatype}) => view[sizes[datatype]](k * step + offset, true))
  );
}

async function main() {
  const reader = await McapIndexedReader.Initialize({readable});
  assert.equal(reader.header.profile, 'ros2');
  const parsers = new Map(),
    messages = {};
  for (const [id, {topic, messageEncoding, schemaId, metadata}] of reader.channelsById) {
    const {encoding, data} = reader.schemasById.get(schemaId);
    assert.deepEqual([messageEncoding, encoding], ['cdr', 'ros2msg']);
    assert.equal(
      /durability: 1/.test(metadata.get('offered_qos_profiles')),
      /tf_static|robot_description/.test(topic),
      `durability of ${topic}`
    );
    parsers.set(id, new MessageReader(parse(new TextDecoder().decode(data), {ros2: true})));
  }
  let last = 0n,
    count = 0n;
  for await (const {channelId, data, logTime} of reader.readMessages({validateCrcs: true})) {
    const message = parsers.get(channelId).readMessage(data);
    const {sec, nanosec} = message.header?.stamp ?? {};
    assert(logTime >= last && (!message.header || BigInt(sec) * 1000000000n + BigInt(nanosec) === logTime));
    if (message.fields) message.points = pointsOf(message);
    (messages[reader.channelsById.get(channelId).topic] ??= []).push(message);
    ((last = logTime), ++count);
  }
  assert.equal(reader.statistics.messageCount, count);
  console.log(
    JSON.stringify(messages, (_, value) =>
      value instanceof Uint8Array
        ? Buffer.from(value).toString('hex')
        : ArrayBuffer.isView(value)
          ? Array.from(value)
          : value
    )
  );
}

main().catch((error) => {
  console.error(error.message);
  process.exit(1);
});
