// The tokenizer as a process: one JSON object a line in, one a line out.
//
// argv: the tokenizer's file, its SHA-256. What is evaluated are the very bytes that were hashed.
// The package keeps its heap to itself, never frees a source and cannot return the source map;
// so its last statement is given one more name, in memory only, and the buffers are ours.
'use strict';
const { createHash } = require('crypto');
const { readFileSync } = require('fs');
const { createInterface } = require('readline');
const { compileFunction } = require('vm');

const [file, wanted] = process.argv.slice(2);
const EXPORTS = 'module.exports = {\n\t  version: version,';
const SOURCE_BYTES = 65536;
// The tokenizer's result record. Ref: S3 (index.js, `parse`): offsets of TModuleRec.
const RECORD_BYTES = 6508;
// Two 16-bit words a statement, and it cannot read more than 10,240 elements.
const MAP_BYTES = 4 * 10242;

let heap; // { module, source, record, map } of the loaded tokenizer

function say(answer) {
  process.stdout.write(JSON.stringify(answer) + '\n');
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
    packets: base64(4201, 4201 + 18 * view.getUint8(4200)),
    map: pairs,
  };
}

try {
  say({ ready: load() });
} catch (error) {
  say({ fatal: String(error && error.message) });
  process.exit(1);
}
createInterface({ input: process.stdin }).on('line', (line) => {
  const { id, source } = JSON.parse(line);
  try {
    say({ id, ...compile(source) });
  } catch (error) {
    say({ id, fatal: String(error && error.message || error) });
    process.exit(1); // its heap cannot be trusted any more; a new process is started
  }
}).on('close', () => process.exit(0));
