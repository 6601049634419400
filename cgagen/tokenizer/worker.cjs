// The tokenizer as a process: one JSON object a line in, one a line out.
//
// argv: the tokenizer's file, its SHA-256. What is evaluated are the very bytes that were hashed.
// The package keeps its heap to itself, never frees a source and cannot return the source map;
// so its last statement is given one more name, in memory only, and the buffers are ours.
'use strict';
const { createHash } = require('crypto');
const { readFileSync, readSync, writeSync } = require('fs');
const { compileFunction } = require('vm');

const [file, wanted] = process.argv.slice(2);
const EXPORTS = 'module.exports = {\n\t  version: version,';
const SOURCE_BYTES = 65536;
// The tokenizer's result record. Ref: S3 (index.js, `parse`): offsets of TModuleRec.
const RECORD_BYTES = 6508;
// Two 16-bit words a statement, and it cannot read more than 10,240 elements.
const MAP_BYTES = 4 * 10242;

let heap; // { module, source, record, map } of the loaded tokenizer

// Reading and writing wait: there is nothing else to do, and it is twice as fast as events.
function say(answer) {
  let rest = Buffer.from(JSON.stringify(answer) + '\n', 'latin1');
  while (rest.length) rest = rest.subarray(writeSync(1, rest));
}

function* questions() {
  const chunk = Buffer.alloc(1 << 16);
  let parts = [];
  for (;;) {
    const length = readSync(0, chunk);
    if (!length) return; // the other side is gone
    const end = chunk.indexOf(10);
    const complete = end >= 0 && end < length;
    parts.push(Buffer.from(chunk.subarray(0, complete ? end : length)));
    if (!complete) continue;
    yield JSON.parse(Buffer.concat(parts).toString('latin1'));
    parts = [Buffer.from(chunk.subarray(end + 1, length))];
  }
}

function load() {
  const bytes = readFileSync(file);
  const found = createHash('sha256').update(bytes).digest('hex');
  if (found !== wanted) throw new Error('hash ' + found);
  const text = bytes.toString('utf8');
  if (text.split(EXPORTS).length !== 2) throw new Error('exports not found');
  const code = text.replace(EXPORTS, 'module.exports = { Module: Module, version: version,');
  const holder = { exports: {}, paths: [], children: [] };
  compileFunction(code, ['exports', 'require', 'module'], { filename: file })(
    holder.exports, require, holder);
  process.removeAllListeners('uncaughtException'); // it installs one at every load
  const module = holder.exports.Module;
  heap = {
    module,
    source: module._malloc(SOURCE_BYTES + 1),
    record: module._malloc(RECORD_BYTES),
    map: module._malloc(MAP_BYTES),
  };
  return holder.exports.version();
}

function text(pointer) {
  const bytes = heap.module.HEAPU8;
  let end = pointer;
  while (pointer && bytes[end]) end++;
  return Buffer.from(bytes.subarray(pointer, end)).toString('latin1');
}

function compile(source) {
  const { module, source: at, record, map } = heap;
  const bytes = module.HEAPU8;
  bytes.fill(0, at, at + SOURCE_BYTES + 1);
  bytes.fill(0, record, record + RECORD_BYTES);
  bytes.fill(0, map, map + MAP_BYTES);
  bytes.set(Buffer.from(source, 'latin1'), at);
  const view = new DataView(bytes.buffer, record, RECORD_BYTES);
  const word = (offset) => view.getInt32(offset, true);
  view.setInt32(88, source.length, true);
  module._Compile(record, at, 0, 1, map);
  const base64 = (start, end) =>
    Buffer.from(bytes.subarray(record + start, record + end)).toString('base64');
  const words = new DataView(bytes.buffer, map, MAP_BYTES);
  const pairs = [];
  for (let i = 0; i < MAP_BYTES && words.getUint16(i + 2, true); i += 4) {
    pairs.push([words.getUint16(i, true), words.getUint16(i + 2, true)]);
  }
  return {
    ok: view.getUint8(0) === 1,
    error: text(word(4)),
    error_start: word(92),
    error_length: word(96),
    debugs: view.getUint8(8) === 1,
    target: view.getUint8(9),
    files: [16, 20, 24, 28, 32, 36, 40].map((offset) => text(word(offset))).filter(Boolean),
    port: text(word(72)),
    language: word(80),
    eeprom: base64(100, 2148),
    flags: base64(2148, 4196),
    variables: [4196, 4197, 4198, 4199].map((offset) => view.getUint8(offset)),
    map: pairs,
  };
}

try {
  say({ ready: load() });
} catch (error) {
  say({ fatal: String(error && error.message) });
  process.exit(1);
}
for (const { id, source } of questions()) {
  try {
    say({ id, ...compile(source) });
  } catch (error) {
    say({ id, fatal: String((error && error.message) || error) });
    process.exit(1); // its heap cannot be trusted any more; a new process is started
  }
}
process.exit(0);
