// Reads an exported MCAP file with the readers of the MCAP project and compares it with the expected contents.
// node read_mcap.cjs NODE_MODULES FILE IMAGE_TOPIC INFO_TOPIC IMU_TOPIC EXPECTED
"use strict";
const fs = require("fs");
const path = require("path");
const [modules, file, imageTopic, infoTopic, imuTopic, expected] = process.argv.slice(2);
const load = require("module").createRequire(path.join(modules, "node_modules", "x.js"));
const { McapIndexedReader } = load("@mcap/core");
const { parse } = load("@foxglove/rosmsg");
const { MessageReader } = load("@foxglove/rosmsg2-serialization");
const assert = require("assert");

class File {
  constructor(name) {
    this.fd = fs.openSync(name);
  }
  async size() {
    return BigInt(fs.fstatSync(this.fd).size);
  }
  async read(offset, length) {
    const bytes = new Uint8Array(Number(length));
    assert.equal(fs.readSync(this.fd, bytes, 0, Number(length), Number(offset)), Number(length));
    return bytes;
  }
}

// One row an array of numbers, but for the stamp, a BigInt.
const rows = (name) =>
  fs.readFileSync(path.join(expected, name), "utf8").trim().split("\n").map((line) => {
    const fields = line.split(",");
    return [BigInt(fields[0]), ...fields.slice(1).map(Number)];
  });
const stampOf = (m) => BigInt(m.header.stamp.sec) * 1000000000n + BigInt(m.header.stamp.nanosec);
const near = (a, b, tolerance) =>
  assert(Math.abs(a - b) <= tolerance, `${a} is not ${b} within ${tolerance}`);

function checkPose(message, row) {
  const { position: p, orientation: q } = message.pose;
  assert.deepEqual([stampOf(message), p.x, p.y, p.z], row.slice(0, 4));
  const R = [
    1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y - q.z * q.w), 2 * (q.x * q.z + q.y * q.w),
    2 * (q.x * q.y + q.z * q.w), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z - q.x * q.w),
    2 * (q.x * q.z - q.y * q.w), 2 * (q.y * q.z + q.x * q.w), 1 - 2 * (q.x * q.x + q.y * q.y),
  ];
  R.forEach((r, i) => near(r, row[4 + i], 1e-14)); // a quaternion's rounding
}

function checkEstimate(message, row) {
  const { pose, covariance } = message.pose;
  [1e-6, 4e-6, 9e-6, 2e-6, 2e-6, 2e-6].forEach((p, i) => near(covariance[7 * i], p, 1e-18));
  // The file that the estimate comes from has a quaternion, too: twice its rounding.
  checkPose({ header: message.header, pose }, row);
}

function checkImage(message, stamp) {
  assert.equal(stampOf(message), stamp);
  const name = path.join(expected, `${stamp}`);
  if (message.format !== undefined) {
    assert.equal(message.format, "png");
    assert(Buffer.from(message.data).equals(fs.readFileSync(`${name}.png`)), `image ${stamp} differs`);
  } else {
    assert.equal(message.encoding, "mono8");
    assert.equal(message.step, message.width);
    assert(Buffer.from(message.data).equals(fs.readFileSync(`${name}.grey`)), `image ${stamp} differs`);
  }
}

function checkImu(message, row) {
  const { angular_velocity: w, linear_acceleration: a } = message;
  assert.equal(stampOf(message), row[0]);
  [w.x, w.y, w.z, a.x, a.y, a.z].forEach((x, i) => near(x, row[1 + i], 1e-12 * (1 + Math.abs(x))));
  assert.equal(message.orientation_covariance[0], -1);
  near(message.angular_velocity_covariance[4], 1e-4, 1e-18); // (0.01 rad/s)²
}

async function main() {
  const reader = await McapIndexedReader.Initialize({ readable: new File(file) });
  assert.equal(reader.header.profile, "ros2");
  const parsers = new Map();
  for (const [id, channel] of reader.channelsById) {
    assert.equal(channel.messageEncoding, "cdr");
    const schema = reader.schemasById.get(channel.schemaId);
    assert.equal(schema.encoding, "ros2msg");
    parsers.set(id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
  }
  const read = new Map();
  let last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    assert(message.logTime >= last);
    last = message.logTime;
    const topic = reader.channelsById.get(message.channelId).topic;
    const decoded = parsers.get(message.channelId).readMessage(message.data);
    assert.equal(stampOf(decoded), message.logTime);
    if (!read.has(topic)) read.set(topic, []);
    read.get(topic).push(decoded);
  }
  const check = (topic, list, one) => {
    assert.equal(read.get(topic)?.length, list.length, `messages of ${topic}`);
    list.forEach((row, i) => one(read.get(topic)[i], row));
  };
  check("/ground_truth/pose", rows("truth.csv"), checkPose);
  check("/slam/pose", rows("slam.csv"), checkEstimate);
  check("/plan/pose", rows("plan.csv"), checkPose);
  check(imageTopic, rows("images.csv"), (m, row) => checkImage(m, row[0]));
  check(infoTopic, rows("images.csv"), (m, row) => {
    assert.equal(stampOf(m), row[0]);
    const pinhole = fs.existsSync(path.join(expected, "undistorted"));
    assert.equal(m.distortion_model, pinhole ? "plumb_bob" : "equidistant");
    if (pinhole) assert.deepEqual([...m.d, m.k[0]], [0, 0, 0, 0, 0, m.k[4]]);
    else assert.equal(m.d.length, 4);
    assert.deepEqual([m.width, m.height, m.k[2], m.k[5]], [64, 48, 31.4, 25.4]);
  });
  check(imuTopic, rows("imu.csv"), checkImu);
  assert.equal(reader.statistics.messageCount, BigInt([...read.values()].reduce((n, l) => n + l.length, 0)));
}

main().catch((error) => {
  console.error(error.message);
  process.exit(1);
});
