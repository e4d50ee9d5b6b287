// The samples of runs, without drawing. All data enter through `append`, both when a page reads its own file and when it
// receives rows during a live run.

'use strict';

function decode(text, Type) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return new Type(bytes.buffer);
}

// The largest index with times[index] <= t, at least 0.
function indexAt(times, t) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t) low = middle; else high = middle - 1;
  }
  return low;
}

// A typed array that grows.
class Growing {
  constructor(Type) {
    this.data = new Type(0);
    this.length = 0;
  }
  push(values) {
    const length = this.length + values.length;
    if (this.length === 0 && values.constructor === this.data.constructor) {
      this.data = values;
    } else {
      if (length > this.data.length) {
        const old = this.values();
        this.data = new this.data.constructor(Math.max(2 * this.length, length));
        this.data.set(old);
      }
      if (Array.isArray(values)) values = values.map((value) => value === null ? NaN : value);  // JSON has no NaN
      this.data.set(values, this.length);
    }
    this.length = length;
  }
  values() {
    return this.data.subarray(0, this.length);
  }
  // Keeps only the numbers [first, end).
  keep(first, end) {
    this.data.copyWithin(0, first, end);
    this.length = end - first;
  }
}

// Indices [first, end) of the times from `from` to `to`, including the last time before `from`, whose value still holds there.
function rangeOf(times, from, to) {
  return times.length > 0 && times[0] <= to ? [indexAt(times, from), indexAt(times, to) + 1] : [0, 0];
}

// The shapes of a run over time: WIDTH columns for each shape, in the order of Shape::Fields().
class Frames {
  constructor(shapes) {
    this.shapes = shapes;
    this.times = new Growing(Float64Array);
    this.columns = [];  // a Growing, or a number for a column that has never changed
    this.cuts = 0;      // how often frames were removed
  }
  get length() {
    return this.times.length;
  }
  get time() {
    return this.times.values();
  }
  // columns[c]: one value for each time, or one number for all times.
  append(times, columns) {
    const before = this.length;
    columns.forEach((given, c) => {
      const added = given === null ? NaN : given, old = this.columns[c];
      if (typeof added === 'number' && (before === 0 || added === old)) {
        this.columns[c] = added;
        return;
      }
      if (before === 0 || typeof old === 'number') {
        this.columns[c] = new Growing(Float32Array);
        this.columns[c].push(new Float32Array(before).fill(old));
      }
      this.columns[c].push(typeof added === 'number' ? new Float32Array(times.length).fill(added) : added);
    });
    this.times.push(times);
  }
  keep(first, end) {
    if (first === 0 && end === this.length) return;
    ++this.cuts;
    for (const column of this.columns) if (typeof column !== 'number') column.keep(first, end);
    this.times.keep(first, end);
  }
  at(column, frame) {
    const values = this.columns[column];
    return typeof values === 'number' ? values : values.data[frame];
  }
}

// The samples, events and figures of one run.
class Recording {
  constructor({name, verdict, good, figures, bands, limits, shapes}) {
    Object.assign(this, {name, verdict, good, figures, limits: limits || []});
    // If a band has no intervals, they are derived from the samples of its signal.
    this.bands = (bands || []).map((band) => ({...band, intervals: band.intervals || [], grows: !(band.intervals || []).length}));
    this.end = 0;  // time of the newest sample
    this.events = [];
    this.signals = new Map();  // by name: {name, unit, time, values}
    this.frames = new Frames(shapes || []);
  }

  // Appends any of these: {names, units, time, values}, where values[i] belongs to names[i]; frames: {time, columns}, see
  // Frames; events: [{time, label}]. Signals that first arrive in one call share their times, and must arrive together later.
  append({names = [], units, time, values, frames, events}) {
    const fresh = names.filter((name) => !this.signals.has(name));
    const times = new Growing(Float64Array);
    for (const name of fresh) {
      const unit = units ? units[names.indexOf(name)] : '';
      this.signals.set(name, {name, unit: prettyUnit(unit), times, samples: new Growing(Float32Array)});
    }
    names.forEach((name, i) => this.signals.get(name).samples.push(values[i]));
    for (const shared of new Set(names.map((name) => this.signals.get(name).times))) shared.push(time);
    for (const name of names) {
      const signal = this.signals.get(name);
      if (signal.samples.length !== signal.times.length)
        throw new Error(`${name} has ${signal.samples.length} values at ${signal.times.length} times`);
      this.view(signal);
    }
    for (const band of this.bands) {
      const column = names.findIndex((name) => name === band.signal || name.startsWith(`${band.signal}.`));
      if (band.grows && column >= 0) Recording.extend(band, time, values[column]);
    }
    if (frames) this.frames.append(frames.time, frames.columns);
    if (events) this.events.push(...events);
    const last = (times) => times && times.length ? times[times.length - 1] : 0;
    this.end = Math.max(this.end, last(names.length ? time : null), last(frames && frames.time),
                        ...(events || []).map((event) => event.time));
  }

  view(signal) {
    signal.time = signal.times.values();
    signal.values = signal.samples.values();
  }

  // Adds an interval to the band for each change of its signal.
  static extend(band, time, values) {
    values.forEach((value, i) => {
      const before = band.intervals[band.intervals.length - 1];
      if (before && before.value === value) return;
      band.intervals.push({time: time[i], value, name: band.names[value] === undefined ? formatNumber(value) : band.names[value]});
    });
  }

  // Removes all samples before `from` or after `to`.
  keep(from, to) {
    const ranges = new Map();  // by the array of times that signals share
    for (const signal of this.signals.values()) {
      const {times} = signal;
      if (!ranges.has(times)) ranges.set(times, rangeOf(times.values(), from, to));
      signal.samples.keep(...ranges.get(times));
    }
    for (const [times, range] of ranges) times.keep(...range);
    for (const signal of this.signals.values()) this.view(signal);
    this.frames.keep(...rangeOf(this.frames.time, from, to));
    this.events = this.events.filter(({time}) => time >= from && time <= to);
    for (const band of this.bands) {
      band.intervals = band.intervals.filter(({time}, i, all) => time <= to && !(i + 1 < all.length && all[i + 1].time <= from));
    }
    const last = (times) => times.length ? times.values()[times.length - 1] : 0;
    this.end = Math.max(0, last(this.frames.times), ...[...ranges.keys()].map(last), ...this.events.map(({time}) => time));
  }

  // The time of the oldest sample.
  get start() {
    const first = [this.frames.time, ...[...this.signals.values()].slice(0, 1).map((signal) => signal.time)];
    const times = first.filter((time) => time.length > 0).map((time) => time[0]);
    return times.length ? Math.min(...times) : 0;
  }

  // Finds signals by name; a name without an element selects all elements, and a path, xy:NAME, the first two.
  find(name) {
    if (name.startsWith('xy:')) return this.find(name.slice(3)).slice(0, 2);
    const own = this.signals.get(name);
    return own ? [own] : [...this.signals.values()].filter((signal) => signal.name.startsWith(`${name}.`));
  }

  // The limits {low, high} of a signal, either of which can be null, or undefined.
  limitsOf(name) {
    const found = this.limits.find(({signal}) => name === signal || name.startsWith(`${signal}.`));
    return found && {low: found.limits[0], high: found.limits[1]};
  }

  // Reads a run from the data in the page.
  static read(run) {
    const recording = new Recording({...run, shapes: run.frames && run.frames.shapes});
    recording.append({events: run.events});
    if (run.samples) {
      const {time, groups} = run.samples;
      const times = typeof time === 'string' ? decode(time, Float64Array) :
          Float64Array.from({length: time.count}, (_, i) => Number((time.start + i * time.step).toPrecision(12)));
      for (const {rows, columns} of groups) {
        recording.append({
          names: columns.map((column) => column.name), units: columns.map((column) => column.unit),
          time: Float64Array.from(decode(rows, Uint16Array), (row) => times[row]),
          values: columns.map((column) => decode(column.values, Float32Array)),
        });
      }
    }
    if (run.frames && run.frames.shapes.length > 0) {
      const time = decode(run.frames.time, Float64Array), data = decode(run.frames.data, Float32Array);
      const columns = [...decode(run.frames.first, Float32Array)];
      run.frames.moving.forEach((column, i) => columns[column] = data.subarray(i * time.length, (i + 1) * time.length));
      recording.append({frames: {time, columns}});
    }
    return recording;
  }
}
