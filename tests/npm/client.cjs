// Parallax's programmer (npm bs2-serial) with a transport of ours: bytes over a socket or a pty,
// DTR and BREAK as lines of text over a second socket.
//
// argv: the node_modules folder. stdin: one JSON list of jobs; stdout: one JSON list of results.
'use strict';
const { EventEmitter } = require('events');
const fs = require('fs');
const net = require('net');
const path = require('path');
const tty = require('tty');

const MODULES = process.argv[2];
const use = (name) => require(path.join(MODULES, name));
global.chrome = { serial: {}, runtime: {} }; // what its own transport asks for when it is loaded
const when = use('when');
const Board = use('bs2-serial/lib/board');
const Protocol = use('bs2-serial-protocol');
const programmer = use('bs2-programmer');

const HEARD_LIMIT_MS = 5000;

class Transport extends EventEmitter {
  constructor(options) {
    super();
    this.place = options.path;
    this.control = options.control;
    this.autoRecover = true;
    this.answers = [];
  }

  isOpen() { return Boolean(this.data); }
  isPaused() { return false; }
  pause() { return when.resolve(); }
  unpause() { return when.resolve(); }
  flush() { return when.resolve(); } // nothing is kept here

  open() {
    if (this.data) return when.resolve();
    return when.promise((resolve, reject) => {
      this.hand = socket(this.control, () => {
        if (this.place.startsWith('/')) this.file = fs.openSync(this.place, 'r+');
        this.data = this.file ? new tty.ReadStream(this.file) : socket(this.place, () => {});
        this.data.on('data', (chunk) => this.emit('data', chunk));
        this.data.on('error', () => {});
        this.emit('open');
        if (this.file) resolve();
        else this.data.once('connect', resolve);
      });
      this.hand.on('error', reject);
      this.hand.on('close', () => this.answers.forEach((answer) => answer('control is gone')));
      let rest = '';
      this.hand.on('data', (chunk) => {
        const lines = (rest + chunk).split('\n');
        rest = lines.pop();
        lines.forEach((line) => this.answers.shift()(line));
      });
    });
  }

  close() {
    if (!this.data) return when.resolve();
    this.data.destroy();
    if (this.file) fs.closeSync(this.file);
    this.hand.destroy();
    this.data = null;
    return when.promise((resolve) => this.hand.once('close', () => resolve(this.emit('close'))));
  }

  send(bytes) {
    return when.promise((resolve) => {
      if (this.file) resolve(fs.writeSync(this.file, bytes));
      else this.data.write(bytes, resolve);
    });
  }

  order(line) {
    return when.promise((resolve, reject) => {
      this.answers.push((said) => (said === line ? resolve() : reject(new Error(said))));
      this.hand.write(line + '\n');
    });
  }

  set({ dtr }) { return this.order(`DTR ${dtr ? 1 : 0}`); }
  setBreak() { return this.order('BREAK 1'); }
  clearBreak() { return this.order('BREAK 0'); }
}

function socket(place, connected) {
  const [host, port] = place.split(':');
  return net.connect({ host, port: Number(port), noDelay: true }, connected);
}

async function identify({ place, control, revision }) {
  const protocol = new Protocol({ path: place, control, transport: Transport });
  return { board: await programmer.identify({ protocol, revision }) };
}

async function bootload({ place, control, revision, source, wanted }) {
  const board = new Board({ path: place, control, revision, transport: Transport });
  const progress = [];
  let heard = '';
  const all = when.promise((resolve) => {
    const late = setTimeout(resolve, HEARD_LIMIT_MS);
    board.on('terminal', (events) => {
      heard += events.map((event) => (event.type === 'text' ? event.data : `<${event.type}>`)).join('');
      if (!heard.includes(wanted)) return;
      clearTimeout(late);
      resolve();
    });
  });
  board.on('progress', (percent) => progress.push(percent));
  try {
    await board.bootload(source);
    await all;
    return { heard, progress };
  } finally {
    await board.close();
  }
}

async function main() {
  const results = [];
  for (const job of JSON.parse(fs.readFileSync(0, 'utf8'))) {
    try {
      results.push(await (job.what === 'identify' ? identify(job) : bootload(job)));
    } catch (error) {
      results.push({ error: error.message || String(error) });
    }
  }
  process.stdout.write(JSON.stringify(results), () => process.exit(0));
}

main();
