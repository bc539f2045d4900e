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

const fd = fs.openSync(file);
const readable = {
  size: async () => BigInt(fs.fstatSync(fd).size),
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length));
    assert.equal(fs.readSync(fd, bytes, 0, Number(length), Number(offset)), Number(length));
    return bytes;
  },
};

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
  const ending = message.format === undefined ? "grey" : "png";
  if (ending === "png") assert.equal(message.format, "png");
  else assert.deepEqual([message.encoding, message.step], ["mono8", message.width]);
  const data = fs.readFileSync(path.join(expected, `${stamp}.${ending}`));
  assert(Buffer.from(message.data).equals(data), `image ${stamp} differs`);
}

function checkImu(message, row) {
  const { angular_velocity: w, linear_acceleration: a } = message;
  assert.equal(stampOf(message), row[0]);
  [w.x, w.y, w.z, a.x, a.y, a.z].forEach((x, i) => near(x, row[1 + i], 1e-12 * (1 + Math.abs(x))));
  assert.equal(message.orientation_covariance[0], -1);
  near(message.angular_velocity_covariance[4], 1e-4, 1e-18); // (0.01 rad/s)²
}

const same = (a, b) => assert.deepEqual([a.x, a.y, a.z], b);

function checkTransforms(messages, files) {
  const frames = new Map();
  for (const message of messages)
    for (const { header, child_frame_id: child, transform } of message.transforms) {
      if (header.frame_id === "waist") continue;
      assert.equal(header.frame_id, "world");
      if (!frames.has(child)) frames.set(child, []);
      frames.get(child).push({ header, pose: { position: transform.translation, orientation: transform.rotation } });
    }
  assert.deepEqual([...frames.keys()].sort(), Object.keys(files).sort());
  for (const [child, name] of Object.entries(files)) {
    const expected = rows(`${name}.csv`);
    assert.equal(frames.get(child).length, expected.length, `transforms of ${child}`);
    expected.forEach((row, i) => checkPose(frames.get(child)[i], row));
  }
}

// The test's robot: the first joint moves the thigh along x, the second one the shin along y.
function checkRobot(descriptions, messages) {
  assert.deepEqual(descriptions.map(({ data }) => data), ["<robot/>"]);
  const links = messages.flatMap(({ transforms }) => transforms).filter(({ header }) => header.frame_id === "waist");
  const joints = rows("links.csv");
  assert.equal(links.length, 2 * joints.length);
  joints.forEach(([t, hip, knee], i) => {
    const [thigh, shin] = links.slice(2 * i, 2 * i + 2);
    assert.deepEqual([stampOf(thigh), thigh.child_frame_id, shin.child_frame_id], [t, "thigh", "shin"]);
    same(thigh.transform.translation, [hip, 0, 0]);
    same(shin.transform.translation, [0, knee, 0]);
  });
}

function checkPath(messages, name) {
  assert.equal(messages.length, 2, "paths: the first and the last");
  const expected = rows(name), { poses } = messages[1];
  assert.equal(messages[0].poses.length, 1);
  assert.equal(poses.length, expected.length);
  expected.forEach((row, i) => checkPose(poses[i], row));
}

// x, y, z as float32 and id as uint32, as the message's own fields say.
function checkMaps(messages) {
  const points = [];
  for (const message of messages) {
    assert.equal(message.data.length, message.width * message.point_step);
    const view = new DataView(message.data.buffer, message.data.byteOffset);
    const at = Object.fromEntries(message.fields.map((field) => [field.name, field]));
    assert.deepEqual([at.x.datatype, at.y.datatype, at.z.datatype, at.id.datatype], [7, 7, 7, 6]);
    for (let k = 0; k < message.width; ++k) {
      const xyz = ["x", "y", "z"].map((n) => view.getFloat32(k * message.point_step + at[n].offset, true));
      const id = view.getUint32(k * message.point_step + at.id.offset, true);
      points.push([stampOf(message) - 1000000000000000000n, id, ...xyz]);
    }
  }
  assert.deepEqual(points, rows("map.csv"));
}

function checkViewerTopics(read, check) {
  checkTransforms(read.get("/tf"), { plan_camera: "plan", slam_camera: "slam" });
  checkTransforms(read.get("/ground_truth/tf"), { "ground_truth/camera": "truth", "ground_truth/waist": "waist",
    "ground_truth/left_foot": "left_foot", "ground_truth/right_foot": "right_foot" });
  checkRobot(read.get("/robot_description"), read.get("/tf"));
  assert.equal(read.get("/tf_static").length, 1);
  const { header, child_frame_id: child, transform } = read.get("/tf_static")[0].transforms[0];
  assert.deepEqual([header.frame_id, child], ["cam0_optical_frame", "imu"]);
  checkPose({ header, pose: { position: transform.translation, orientation: transform.rotation } }, rows("X_CG.csv")[0]);
  checkPath(read.get("/ground_truth/path"), "truth.csv");
  checkPath(read.get("/plan/path"), "plan.csv");
  checkPath(read.get("/slam/path"), "slam.csv");
  checkMaps(read.get("/slam/map"));
  check("/joint_states", rows("joints.csv"), (m, row) => {
    assert.deepEqual(m.name, ["hip", "knee"]);
    assert.deepEqual([stampOf(m), ...m.position], row);
    assert.equal(m.velocity.length + m.effort.length, 0);
  });
  for (const foot of ["left", "right"])
    check(`/${foot}_foot/wrench`, rows(`${foot}_wrench.csv`), (m, row) => {
      assert.deepEqual([stampOf(m), m.header.frame_id], [row[0], `${foot}_foot`]);
      same(m.wrench.force, row.slice(1, 4));
      same(m.wrench.torque, row.slice(4));
    });
}

async function main() {
  const reader = await McapIndexedReader.Initialize({ readable });
  assert.equal(reader.header.profile, "ros2");
  const parsers = new Map();
  for (const [id, channel] of reader.channelsById) {
    assert.equal(channel.messageEncoding, "cdr");
    const schema = reader.schemasById.get(channel.schemaId);
    assert.equal(schema.encoding, "ros2msg");
    parsers.set(id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
  }
  for (const { topic, metadata } of reader.channelsById.values())
    assert.equal(/durability: 1/.test(metadata.get("offered_qos_profiles")),
      /tf_static|robot_description/.test(topic), `durability of ${topic}`);
  const read = new Map();
  let last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    assert(message.logTime >= last);
    last = message.logTime;
    const topic = reader.channelsById.get(message.channelId).topic;
    const decoded = parsers.get(message.channelId).readMessage(message.data);
    if (decoded.header) assert.equal(stampOf(decoded), message.logTime);
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
  if (imageTopic.endsWith("compressed")) checkViewerTopics(read, check);
  else assert(!read.has("/tf"));
  assert.equal(reader.statistics.messageCount, BigInt([...read.values()].reduce((n, l) => n + l.length, 0)));
}

main().catch((error) => {
  console.error(error.message);
  process.exit(1);
});
