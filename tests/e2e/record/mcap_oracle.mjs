// Oracle for recordings: the official packages of MCAP and Foxglove.
//
//   node mcap_oracle.mjs MODULES check FILE.mcap EXPECTED.jsonl   both readers check every message and checksum
//   node mcap_oracle.mjs MODULES write SOURCE.mcap OUT.mcap       copies the messages with their writer
//   node mcap_oracle.mjs MODULES time FILE.mcap SEEKS             measures a full read, and seeks
//
// MODULES: a node_modules folder with @mcap/core, @mcap/support, @mcap/nodejs, flatbuffers,
// flatbuffers_reflection. Exits with 77 if they are missing.
import { createRequire } from 'node:module';
import fs from 'node:fs';
import { open } from 'node:fs/promises';
import path from 'node:path';

const [modules, task, file, other] = process.argv.slice(2);
const require = createRequire(path.join(path.resolve(modules), 'x.js'));
let core, support, nodejs, flatbuffers, reflection;
try {
  core = require('@mcap/core');
  support = require('@mcap/support');
  nodejs = require('@mcap/nodejs');
  flatbuffers = require('flatbuffers');
  reflection = require('flatbuffers_reflection');
} catch (missing) {
  console.error(`mcap_oracle: ${missing.message.split('\n')[0]}`);
  process.exit(77);
}

function check(condition, text) {
  if (condition) return;
  console.error(`mcap_oracle: ${text}`);
  process.exit(1);
}

async function indexed() {
  const readable = new nodejs.FileHandleReadable(await open(file, 'r'));
  return core.McapIndexedReader.Initialize({ readable, decompressHandlers: await support.loadDecompressHandlers() });
}

// --- messages, decoded with the schemas of the file

function schemaOf(record) {
  return reflection.Schema.getRootAsSchema(new flatbuffers.ByteBuffer(record.data));
}

function fieldsOf(schema, table) {
  for (let i = 0; i < schema.objectsLength(); i++) {
    const object = schema.objects(i);
    if (object.name() !== table) continue;
    const fields = {};
    for (let j = 0; j < object.fieldsLength(); j++) fields[object.fields(j).name()] = object.fields(j).offset();
    return fields;
  }
  check(false, `the schema has no ${table}`);
}

// Returns the offset of a field in a table, or 0.
const at = (bytes, table, offset) => {
  const vtable = table - bytes.readInt32(table);
  const place = offset < bytes.readInt16(vtable) ? bytes.readInt16(vtable + offset) : 0;
  return place === 0 ? 0 : table + place;
};
const follow = (bytes, table, offset) => {
  const place = at(bytes, table, offset);
  return place === 0 ? 0 : place + bytes.readInt32(place);
};

// Their parser does not support fixed-size arrays: the poses are decoded by the offsets of the schema.
function nativeMessage(schema, data) {
  const bytes = new flatbuffers.ByteBuffer(data);
  const envelope = fieldsOf(schema, 'fire3dv.wire.fbs.Message');
  const root = bytes.readInt32(0);
  const kind = bytes.readUint8(at(bytes, root, envelope.body_type));
  const body = follow(bytes, root, envelope.body);
  if (kind === 1) {
    const fields = fieldsOf(schema, 'fire3dv.wire.fbs.StreamDescription');
    const world = at(bytes, body, fields.world_from_stream);
    const names = follow(bytes, body, fields.node_names);
    return {
      world: Array.from({ length: 12 }, (_, i) => bytes.readFloat64(world + 8 * i)),
      names: Array.from({ length: bytes.readInt32(names) },
                        (_, i) => bytes.__string(names + 4 + 4 * i)),
    };
  }
  if (kind !== 2) return {};
  const fields = fieldsOf(schema, 'fire3dv.wire.fbs.PoseFrame');
  const number = (name, read, absent) => {
    const place = at(bytes, body, fields[name]);
    return place === 0 ? absent : bytes[read](place);
  };
  const poses = follow(bytes, body, fields.poses), indices = follow(bytes, body, fields.node_indices);
  const first = number('first_node', 'readUint32', 0);
  const result = { sequence: Number(number('sequence', 'readUint64', 0n)), poses: new Map() };
  for (let i = 0; i < bytes.readInt32(poses); i++)
    result.poses.set(indices ? bytes.readUint32(indices + 4 + 4 * i) : first + i,
                     Array.from({ length: 12 }, (_, k) => bytes.readFloat32(poses + 4 + 48 * i + 4 * k)));
  return result;
}

function foxgloveMessage(schemaRecord, data) {
  const parser = new reflection.Parser(schemaOf(schemaRecord));
  const table = reflection.Table.getNamedTable(new flatbuffers.ByteBuffer(data), schemaOf(schemaRecord), schemaRecord.name);
  return parser.toObject(table, true);
}

// --- check

function product(a, b) {
  const result = [];
  for (let row = 0; row < 3; row++)
    for (let column = 0; column < 4; column++) {
      let sum = column === 3 ? a[row * 4 + 3] : 0;
      for (let k = 0; k < 3; k++) sum += a[row * 4 + k] * b[k * 4 + column];
      result.push(sum);
    }
  return result;
}

// Foxglove's root frame is Z up, the world of the scene Y up.
const zUp = (m) => [...m.slice(0, 4), ...m.slice(8, 12).map((value) => -value), ...m.slice(4, 8)];

function checkTransform(told, expected, what) {
  const { x, y, z, w } = told.rotation, scale = 0.001;
  const rotation = [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
                    2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                    2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)];
  for (let i = 0; i < 9; i++)
    check(Math.abs(rotation[i] * scale - expected[Math.floor(i / 3) * 4 + i % 3]) < 1e-9, `${what} is turned otherwise`);
  const place = [told.translation.x, told.translation.y, told.translation.z];
  for (let i = 0; i < 3; i++) check(Math.abs(place[i] - expected[4 * i + 3]) < 1e-12, `${what} is elsewhere`);
}

// The arrow and the cloud of record_sample, in metres. The stream's origin is (0.5, 2, 0) where Z is up.
function checkMarkers(scene, cloud) {
  const entity = scene.entities[0], arrow = entity.arrows[0];
  const near = (value, expected) => Math.abs(value - expected) < 1e-6;
  check(entity.id === 'force' && entity.frame_id === 'world' && entity.arrows.length === 1, 'the arrow is missing');
  check(near(arrow.pose.position.x, 0.5) && near(arrow.pose.position.y, 2) && near(arrow.pose.position.z, 0) &&
        near(arrow.shaft_length + arrow.head_length, 1) && near(arrow.shaft_diameter, 0.02), 'the arrow is elsewhere');
  const { x, y, z, w } = arrow.pose.orientation;  // +x is turned to +z
  check(near(1 - 2 * (y * y + z * z), 0) && near(2 * (x * z - y * w), 1), 'the arrow is turned otherwise');
  check(near(arrow.color.r, 1) && near(arrow.color.g, 128 / 255) && near(arrow.color.b, 0), 'the arrow has another colour');
  const at = Object.fromEntries(cloud.fields.map((field) => [field.name, field.offset]));
  const data = Buffer.from(cloud.data);
  check(cloud.point_stride === 16 && data.length === 32 && near(cloud.pose.position.y, 2), 'the cloud is another one');
  check(near(data.readFloatLE(16 + at.z), 1) && near(data.readFloatLE(at.z), 0) && data[at.red] === 255 &&
        data[at.green] === 128 && data[at.alpha] === 255, 'the points are others');
}

async function checkFile() {
  const expected = fs.readFileSync(other, 'utf8').trim().split('\n').map((line) => JSON.parse(line));
  const reader = await indexed();
  const native = [], foxglove = [];
  let description, scenes = 0, schema, transforms = 0, markers, cloud;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    const record = reader.schemasById.get(channel.schemaId);
    check(channel.messageEncoding === 'flatbuffer' && record.encoding === 'flatbuffer', 'the encoding is another one');
    if (record.name === 'fire3dv.wire.fbs.Message') {
      schema ??= schemaOf(record);
      const body = nativeMessage(schema, message.data);
      if (body.world) description ??= body;
      if (body.poses) native.push({ ...body, logTime: message.logTime });
    } else if (record.name === 'foxglove.FrameTransforms') {
      foxglove.push({ ...foxgloveMessage(record, message.data), logTime: message.logTime, sequence: message.sequence });
    } else if (channel.topic === '/arm/markers') {
      markers = foxgloveMessage(record, message.data);
    } else if (record.name === 'foxglove.PointCloud') {
      check(channel.topic === '/arm/points/cloud', `an unknown topic: ${channel.topic}`);
      cloud = foxgloveMessage(record, message.data);
    } else {
      check(record.name === 'foxglove.SceneUpdate', `an unknown schema: ${record.name}`);
      const model = foxgloveMessage(record, message.data).entities[0].models[0];
      check(model.media_type === 'model/gltf-binary' && model.data.length === 5000 && model.scale.x === 1 &&
            model.pose.orientation.w === 1, 'the model is another one');
      scenes++;
    }
  }
  check(native.length === expected.length && foxglove.length === expected.length && scenes === 1,
        `${native.length} and ${foxglove.length} messages of ${expected.length}, ${scenes} scenes`);
  check(markers && cloud, 'markers are missing');
  checkMarkers(markers, cloud);
  expected.forEach((wanted, i) => {
    const names = Object.keys(wanted.poses);
    check(native[i].sequence === wanted.sequence && String(native[i].logTime) === wanted.log_time &&
          native[i].poses.size === names.length, `message ${i} is another one`);
    check(foxglove[i].sequence === wanted.sequence && String(foxglove[i].logTime) === wanted.log_time &&
          foxglove[i].transforms.length === names.length, `transforms ${i} are others`);
    for (const [node, pose] of native[i].poses) {
      const numbers = wanted.poses[description.names[node]];
      check(pose.every((value, k) => value === Math.fround(numbers[k])), `pose of ${node} in message ${i}: ${pose}`);
      const told = foxglove[i].transforms.find((each) => each.child_frame_id === description.names[node]);
      check(told && told.parent_frame_id === 'world' &&
            BigInt(told.timestamp.sec) * 1000000000n + BigInt(told.timestamp.nsec) === native[i].logTime,
            `transform of ${node} in message ${i} is missing, or of another time`);
      checkTransform(told, product(zUp(description.world), pose), `${node} in message ${i}`);
      transforms++;
    }
  });
  for await (const attachment of reader.readAttachments({ validateCrcs: true }))
    check(attachment.name === 'scene.glb' && attachment.data.length === 5000, 'the attachment is another one');
  for await (const metadata of reader.readMetadata())
    check(metadata.metadata.get('operator') === 'nobody', 'the metadata is another one');
  check(reader.statistics.attachmentCount === 1 && reader.statistics.metadataCount === 1, 'the statistics are others');
  // Reading from any time on.
  const half = native[Math.floor(native.length / 2)].logTime;
  let later = 0;
  for await (const message of reader.readMessages({ startTime: half, topics: ['/arm/poses'], validateCrcs: true })) later++;
  check(later === native.filter((each) => each.logTime >= half).length, 'a seek gives other messages');
  // The stream reader uses chunks instead of the index.
  const stream = new core.McapStreamReader({ validateCrcs: true, decompressHandlers: await support.loadDecompressHandlers() });
  stream.append(fs.readFileSync(file));
  let streamed = 0;
  for (let record; (record = stream.nextRecord());) streamed += record.type === 'Message' ? 1 : 0;
  check(stream.done() && BigInt(streamed) === reader.statistics.messageCount, 'the stream reader is not done');
  console.log(`${native.length} messages of ours and ${transforms} transforms are equal`);
}

// --- write

class Out {
  pieces = [];
  size = 0n;
  async write(bytes) {
    this.pieces.push(Buffer.from(bytes));
    this.size += BigInt(bytes.length);
  }
  position() {
    return this.size;
  }
}

async function writeFile() {
  const reader = await indexed(), out = new Out();
  const writer = new core.McapWriter({ writable: out, chunkSize: 20000 });
  await writer.start({ profile: 'fire3dv', library: 'mcap_oracle' });
  const schemas = new Map(), channels = new Map();
  for (const [id, schema] of reader.schemasById)
    schemas.set(id, await writer.registerSchema({ name: schema.name, encoding: schema.encoding, data: schema.data }));
  for (const [id, channel] of reader.channelsById)
    channels.set(id, await writer.registerChannel({ ...channel, schemaId: schemas.get(channel.schemaId) }));
  for await (const message of reader.readMessages())
    await writer.addMessage({ ...message, channelId: channels.get(message.channelId) });
  for await (const attachment of reader.readAttachments()) await writer.addAttachment(attachment);
  for await (const metadata of reader.readMetadata()) await writer.addMetadata(metadata);
  await writer.end();
  fs.writeFileSync(other, Buffer.concat(out.pieces));
}

// --- time

async function timeFile() {
  const ms = (from) => Number(process.hrtime.bigint() - from) / 1e6;
  let begun = process.hrtime.bigint();
  const reader = await indexed();
  const opened = ms(begun);
  const { messageStartTime: first, messageEndTime: last } = reader.statistics;
  const seeks = [];
  for (let i = 0; i < Number(other); i++) {
    const startTime = first + ((last - first) * BigInt(i * 7919 % 1000)) / 1000n;
    begun = process.hrtime.bigint();
    // Equivalent of a seek in fire3dv: the state of the stream at that time, and the first pose after it.
    for (const [topic, options] of [['/arm/control', { endTime: startTime, reverse: true }], ['/arm/poses', { startTime }]])
      for await (const message of reader.readMessages({ topics: [topic], validateCrcs: true, ...options })) break;
    seeks.push(ms(begun));
  }
  seeks.sort((a, b) => a - b);
  let messages = 0, bytes = 0;
  begun = process.hrtime.bigint();
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    messages++;
    bytes += message.data.length;
    if (ms(begun) > 60000) break;
  }
  const seconds = ms(begun) / 1000;
  console.log(JSON.stringify({
    open_ms: opened, seek_median_ms: seeks[Math.floor(seeks.length / 2)], seek_longest_ms: seeks.at(-1),
    messages_per_s: messages / seconds, mb_per_s: bytes / 1e6 / seconds, read_s: seconds,
    peak_rss_mb: process.resourceUsage().maxRSS / 1024,
  }));
}

await { check: checkFile, write: writeFile, time: timeFile }[task]();
process.exit(0);
