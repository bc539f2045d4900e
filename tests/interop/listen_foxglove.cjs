// Listens to a run with the client of the Foxglove project and compares its messages with the result.
// node listen_foxglove.cjs NODE_MODULES URL SUBPROTOCOL RESULT_FOLDER
"use strict";
const fs = require("fs");
const path = require("path");
const assert = require("assert");
const [modules, url, protocol, result] = process.argv.slice(2);
const load = require("module").createRequire(path.join(modules, "node_modules", "x.js"));
const { FoxgloveClient } = load("@foxglove/ws-protocol");
const WebSocket = load("ws");
const { parse } = load("@foxglove/rosmsg");
const { MessageReader } = load("@foxglove/rosmsg2-serialization");

const address = url.replace(/^http/, "ws");
const channels = new Map(), messages = [];
let info;

// The viewer of the page, which limits the run's speed.
const viewer = new WebSocket(address, ["gaitslam.view.v1"]);
viewer.on("open", () => {
  viewer.send(JSON.stringify({ op: "speed", factor: 2 }));
  viewer.send(JSON.stringify({ op: "loaded" }));  // or the end of the run would wait for the page to load
});
const socket = new WebSocket(address, [protocol]);
const client = new FoxgloveClient({ ws: socket });
client.on("serverInfo", (event) => (info = event));
client.on("status", (event) => assert.fail(event.message));
client.on("error", (error) => assert.fail(String(error)));
client.on("advertise", (list) => {
  for (const channel of list) {
    const reader = new MessageReader(parse(channel.schema, { ros2: true }));
    channels.set(client.subscribe(channel.id), { topic: channel.topic, reader });
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const { topic, reader } = channels.get(subscriptionId);
  messages.push({ topic, timestamp, message: reader.readMessage(data) });
});
client.on("close", () => finish().catch((error) => { console.error(error); process.exit(1); }));

const stampOf = ({ stamp }) => BigInt(stamp.sec) * 1000000000n + BigInt(stamp.nanosec);

// "stamp in ns since the start" -> [x, y, z]
function rowsOf(file) {
  const rows = new Map();
  for (const line of fs.readFileSync(path.join(result, file), "utf8").split("\n")) {
    const [t, ...numbers] = line.split(" ");
    if (t && !t.startsWith("#")) rows.set(BigInt(t.replace(".", "")), numbers.slice(0, 3).map(Number));
  }
  return rows;
}

function checkPoses(topic, file) {
  const rows = rowsOf(file), received = messages.filter((m) => m.topic === topic);
  assert(received.length > 20, `${topic}: only ${received.length} messages`);
  for (const { timestamp, message } of received) {
    assert.equal(stampOf(message.header), timestamp);
    const { position } = message.pose.pose ?? message.pose;
    assert.deepEqual([position.x, position.y, position.z], rows.get(timestamp - 1000000000000000000n), `${topic} at ${timestamp}`);
  }
}

// Waits without blocking: the program finishes its result when both sockets have answered its closing
// handshake.
async function resultWritten() {
  for (let i = 0; i < 600 && !fs.existsSync(path.join(result, "score.json")); ++i)
    await new Promise((resolve) => setTimeout(resolve, 100));
}

async function finish() {
  await resultWritten();
  assert.equal(info?.name, "gaitslam");
  checkPoses("/ground_truth/pose", "truth.tum");
  checkPoses("/slam/pose", "estimate.tum");
  checkPoses("/plan/pose", "plan.tum");
  const images = messages.filter((m) => m.topic === "/camera/image/compressed");
  assert(images.length > 20);
  for (const { message, timestamp } of images) {
    const file = path.join(result, "recording/mav0/cam0/data", `${timestamp}.png`);
    assert(Buffer.from(message.data).equals(fs.readFileSync(file)), `image ${timestamp} differs`);
  }
  const imu = messages.filter((m) => m.topic === "/imu");
  assert(imu.length > 5 * images.length, `${imu.length} readings of the IMU`);
  // Every 5 ms, except where the oldest frame in a slow client's queue was dropped.
  const steps = imu.slice(1).map((m, i) => m.timestamp - imu[i].timestamp);
  steps.forEach((step) => assert(step > 0n && step % 5000000n === 0n, `${step} ns between readings of the IMU`));
  assert(steps.filter((step) => step === 5000000n).length > 0.8 * steps.length);
  console.log(JSON.stringify({ messages: messages.length, images: images.length, imu: imu.length }));
  process.exit(0);
}
setTimeout(() => assert.fail("the run does not end"), 100000);
