// A running mission as Foxglove's own client library sees it. Called by tests/live: `node foxglove.mjs search RECORDING` before a
// search is started, and `node foxglove.mjs glance`. It prints `ready` once it has been loaded, so that it misses nothing of a short
// search, and then reads the address; exit code 0 if all holds.

import assert from "node:assert/strict";
import { open, readFile } from "node:fs/promises";
import http from "node:http";
import net from "node:net";
import { createInterface } from "node:readline";

import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import protocol from "@foxglove/ws-protocol";
import { McapIndexedReader } from "@mcap/core";
import { decompress } from "fzstd";
import WebSocket from "ws";

const { FoxgloveClient } = protocol;
const [, , name, recording] = process.argv;
console.log("ready");
const lines = createInterface({ input: process.stdin });
const address = await new Promise((resolve) => lines.once("line", resolve));
lines.close();

/** Topics whose messages are events: all others are states, of which a late client gets the newest. */
const isOfEvents = (topic) => topic === "/objects" || topic.endsWith("/observation");

/** Resolves with the first event for which something holds. */
const first = (emitter, event, holds = () => true) => new Promise((resolve, reject) => {
  emitter.on(event, (value) => { if (holds(value)) resolve(value); });
  emitter.on("close", () => reject(new Error(`closed before ${event}`)));
});

/** A client that subscribes to each topic that is advertised. */
class Watcher {
  channels = new Map();
  messages = new Map();
  times = [];
  statuses = [];

  constructor(protocol = FoxgloveClient.SUPPORTED_SUBPROTOCOL) {
    this.socket = new WebSocket(address, [protocol]);
    this.client = new FoxgloveClient({ ws: this.socket });
    this.over = first(this.client, "status", ({ message }) => message === "the mission is over");
    this.over.catch(() => {});
    this.topics = new Map();
    this.client.on("status", (status) => this.statuses.push(status));
    this.client.on("time", ({ timestamp }) => this.times.push(timestamp));
    this.client.on("advertise", (channels) => channels.forEach((channel) => this.subscribe(channel)));
    this.client.on("message", ({ subscriptionId, timestamp, data }) => {
      const bytes = Buffer.from(data.buffer, data.byteOffset, data.byteLength);
      assert.ok(timestamp <= this.times.at(-1), "the time comes before its messages");
      this.messages.get(this.topics.get(subscriptionId)).push({ time: timestamp, bytes });
    });
  }

  subscribe(channel) {
    const { topic, encoding, schemaName, schema, schemaEncoding } = channel;
    assert.ok(!this.channels.has(topic), `${topic} is advertised twice`);
    this.channels.set(topic, { encoding, schemaName, schema, schemaEncoding });
    this.messages.set(topic, []);
    this.topics.set(this.client.subscribe(channel.id), topic);
    if (topic === "/map") this.map = channel.id;
  }

  /** Resolves once everything is here that the server had to send before it reads this client's next request. */
  async settle() {
    const subscription = [...this.topics].find(([, topic]) => topic === "/map")[0];
    const before = this.messages.get("/map").length;
    this.client.unsubscribe(subscription);
    this.topics.set(this.client.subscribe(this.map), "/map");
    while (this.messages.get("/map").length === before) await first(this.client, "message");
    this.messages.get("/map").pop();
  }

  decode(topic, { bytes }) {
    const { schema } = this.channels.get(topic);
    return new MessageReader(parse(schema, { ros2: true })).readMessage(bytes);
  }

  last(topic) {
    return this.decode(topic, this.messages.get(topic).at(-1));
  }
}

/** Topics and messages of a recording. */
async function read(path) {
  const file = await open(path);
  const readable = {
    size: async () => BigInt((await file.stat()).size),
    read: async (offset, size) => {
      const bytes = new Uint8Array(Number(size));
      await file.read(bytes, 0, bytes.length, Number(offset));
      return bytes;
    },
  };
  const zstd = (bytes, size) => decompress(new Uint8Array(bytes), new Uint8Array(Number(size)));
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: { zstd } });
  const [channels, messages] = [new Map(), new Map()];
  for (const { topic, messageEncoding, schemaId } of reader.channelsById.values()) {
    const { name: schemaName, encoding: schemaEncoding, data } = reader.schemasById.get(schemaId);
    channels.set(topic, { encoding: messageEncoding, schemaName, schema: new TextDecoder().decode(data), schemaEncoding });
    messages.set(topic, []);
  }
  for await (const { channelId, logTime, data } of reader.readMessages()) {
    messages.get(reader.channelsById.get(channelId).topic).push({ time: logTime, bytes: Buffer.from(data) });
  }
  await file.close();
  return { channels, messages };
}

const isSame = (a, b) => a.time === b.time && a.bytes.equals(b.bytes);

/** The newest message of each state of a topic: of transforms that of each robot. */
function newest(watcher, topic, messages) {
  if (topic !== "/tf") return messages.slice(-1);
  const robot = (message) => watcher.decode(topic, message).transforms[0].child_frame_id;
  return [...new Map(messages.map((message) => [robot(message), message])).values()];
}

/** What came while the search ran is in the recording to its end, without a gap; before it come states. */
function checkWhole(watcher, recorded) {
  const sorted = (channels) => [...channels].sort(([a], [b]) => a.localeCompare(b));
  assert.deepEqual(sorted(watcher.channels), sorted(recorded.channels), "topics and schemas are those of the recording");
  let compared = 0;
  for (const [topic, messages] of watcher.messages) {
    const inFile = recorded.messages.get(topic);
    const most = isOfEvents(topic) ? 0 : topic === "/tf" ? 3 : 1;
    const isSuffix = (states) => {
      const rest = messages.slice(states);
      const end = inFile.slice(inFile.length - rest.length);
      return rest.length <= inFile.length && rest.every((message, index) => isSame(message, end[index]));
    };
    const states = [...Array(most + 1).keys()].find(isSuffix);
    assert.notEqual(states, undefined, `${topic}: ${messages.length} of ${inFile.length} messages, with a gap`);
    for (const state of messages.slice(0, states)) {
      assert.ok(inFile.some((message) => isSame(message, state)), `${topic}: a state that is not recorded`);
    }
    messages.forEach((message) => watcher.decode(topic, message));
    compared += messages.length - states;
  }
  assert.ok(compared > 100, `${compared} messages`);
  assert.ok(watcher.messages.get("/robots/1/observation").length > 10);
  assert.ok(watcher.times.every((time, index) => index === 0 || time > watcher.times[index - 1]), "time goes on");
}

/** A client after the end of the search gets the newest of each state, and no event. */
async function checkLate(recorded) {
  const late = new Watcher("foxglove.sdk.v1");
  const info = await first(late.client, "serverInfo");
  assert.deepEqual([info.name, info.capabilities], ["dragnet", ["time"]]);
  await first(late.client, "message");
  await late.settle();
  assert.deepEqual([...late.channels.keys()].sort(), [...recorded.channels.keys()].sort());
  for (const [topic, messages] of late.messages) {
    const expected = isOfEvents(topic) ? [] : newest(late, topic, recorded.messages.get(topic));
    assert.equal(messages.length, expected.length, topic);
    for (const state of expected) assert.ok(messages.some((message) => isSame(message, state)), topic);
  }
  const { info: map } = late.last("/map");
  assert.deepEqual([map.width, map.height], [26, 18]);
  assert.ok(new Set(late.last("/belief").data).size > 3, "the first belief has contrast");
  const closed = new Promise((resolve) => late.socket.on("close", resolve));
  late.client.close();
  assert.equal(await closed, 1005, "the server answers a farewell");
}

/** The layout that is shipped names topics and fields that are there; it has more robots than this search, and the marker of finds. */
async function checkLayout(watcher) {
  const { configById } = JSON.parse(await readFile(new URL("../../../docs/foxglove.json", import.meta.url), "utf8"));
  const topics = Object.keys(configById["3D!search"].topics);
  const missing = topics.filter((topic) => !watcher.channels.has(topic));
  assert.ok(missing.length < topics.length && missing.every((topic) => topic === "/objects/marker" || Number(topic.split("/")[2]) > 3), `${missing}`);
  const { colorField } = configById["3D!search"].topics["/belief/probability"];
  assert.equal(watcher.last("/belief/probability").fields[0].name, colorField);
  const [topic, field] = configById["Plot!remaining"].paths[0].value.split(".");
  assert.equal(typeof watcher.last(topic)[field], "number");
  assert.ok(watcher.channels.has(configById["RawMessages!status"].topicPath));
}

/** A client that subscribes to everything, and reads nothing. */
async function stopReading(channels) {
  const socket = net.connect(new URL(address).port, "127.0.0.1");
  const ids = [...Array(channels).keys()];
  const request = JSON.stringify({ op: "subscribe", subscriptions: ids.map((id) => ({ id, channelId: id })) });
  const length = Buffer.from([request.length >> 8, request.length & 255]);
  socket.pause();
  socket.write(
    "GET / HTTP/1.1\r\nHost: a\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n" +
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n",
  );
  socket.write(Buffer.concat([Buffer.from([0x81, 0xfe]), length, Buffer.alloc(4), Buffer.from(request)]));
  return socket;
}

/** Clients that send what the protocol does not know, or what this server does not serve. */
async function sendGarbage() {
  const noise = net.connect(new URL(address).port, "127.0.0.1");
  noise.on("error", () => {});
  noise.write(Buffer.from([...Array(4096).keys()].map((it) => (it * 37) & 255)));
  await new Promise((resolve) => noise.resume().on("close", resolve));

  const status = await new Promise((resolve) => http.get(address.replace("ws:", "http:"), (reply) => resolve(reply.resume().statusCode)));
  assert.equal(status, 426, "no page is here");
  const refused = async (protocol, options) => {
    const stranger = new WebSocket(address, [protocol], options);
    stranger.on("error", () => {});
    return new Promise((resolve) => stranger.on("unexpected-response", (_, reply) => resolve(reply.destroy().statusCode)));
  };
  assert.equal(await refused("dragnet", {}), 400, "a protocol of others");
  assert.equal(await refused("foxglove.sdk.v1", { origin: "https://evil.example" }), 403, "a website");

  const client = new Watcher();
  await first(client.client, "message");
  const refusals = ["hello", "{}", "[1]", '{"op":"subscribe","subscriptions":[{"id":-1,"channelId":"x"}]}', Buffer.from([1, 2, 3])];
  refusals.push('{"op":"advertise","channels":[{"id":1,"topic":"/cmd_vel","encoding":"json","schemaName":""}]}');
  refusals.push('{"op":"subscribe","subscriptions":[{"id":999,"channelId":999999}]}');
  for (const refusal of refusals) client.socket.send(refusal);
  while (client.statuses.length < refusals.length) await first(client.client, "status");
  assert.ok(client.statuses.every(({ level }) => level === 2), "each is an error");
  const closed = new Promise((resolve) => client.socket.on("close", resolve));
  client.socket.on("error", () => {});
  client.socket.send("x".repeat(2 << 20));
  await closed;
}

async function search() {
  const early = new Watcher();
  await first(early.client, "message");
  const silent = await stopReading(3);
  const garbage = sendGarbage();
  await early.over;
  await garbage;
  const recorded = await read(recording);
  checkWhole(early, recorded);
  await checkLayout(early);
  await checkLate(recorded);
  silent.destroy();
  early.client.close();
}

/** The map and the belief are there before any robot. */
async function glance() {
  const watcher = new Watcher();
  await first(watcher.client, "message");
  await watcher.settle();
  for (const topic of ["/map", "/belief", "/belief/probability"]) assert.equal(watcher.messages.get(topic).length, 1, topic);
  watcher.client.close();
}

await { search, glance }[name]();
