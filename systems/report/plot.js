// One plot: curves of signals over time, of all runs.

'use strict';

const MANY_CURVES = 20;  // plots with more curves start as an envelope, if a run has at least four signals

// Mixes a colour with the background of the plots, for the second and later signals of a run.
function fade(hex, amount) {
  const ground = Theme.color('--panel');
  const part = (color, at) => parseInt(color.slice(at, at + 2), 16);
  const mix = (at) => Math.round(part(hex, at) * (1 - amount) + part(ground, at) * amount);
  return `rgb(${mix(1)}, ${mix(3)}, ${mix(5)})`;
}

// The number of decimals that resolves a thousandth of the range.
function digitsFor({low, high}) {
  const span = Math.max(high - low, 1e-3 * Math.abs(high));
  return span > 0 && Number.isFinite(span) ? Math.min(Math.max(3 - Math.ceil(Math.log10(span)), 0), 9) : 3;
}

// The range of the values, and their noise: the share of the total variation that the next step reverses.
function measure(values) {
  let low = Infinity, high = -Infinity, way = 0, back = 0, last = 0;
  for (let i = 0; i < values.length; ++i) {
    if (!Number.isFinite(values[i])) continue;
    low = Math.min(low, values[i]);
    high = Math.max(high, values[i]);
    const step = i > 0 ? values[i] - values[i - 1] : 0;
    if (step === 0 || !Number.isFinite(step)) continue;
    way += Math.abs(step);
    if (step * last < 0) back += Math.min(Math.abs(step), Math.abs(last));
    last = step;
  }
  return {low, high, noise: way > 1e-6 * Math.max(Math.abs(low), Math.abs(high)) ? back / way : 0};
}

// The shortest decimal number that rounds to this value in single precision.
function shortest(value) {
  for (let digits = 6; digits < 9; ++digits) {
    const short = Number(value.toPrecision(digits));
    if (Math.fround(short) === value) return short;
  }
  return Number(value.toPrecision(9));
}

// Removes the common prefix of dotted names: loop.plant.euler.roll, loop.plant.euler.yaw -> roll, yaw. norm:loop.errors.com and
// rate:loop.errors.com become |com| and d/dt com.
function shortNames(all) {
  const names = all.map((name) => name.replace(/^(norm|rate):/, ''));
  const parts = names.map((name) => name.split('.'));
  let common = 0;
  while (parts.length > 1 && parts.every((p) => p.length > common + 1 && p[common] === parts[0][common])) ++common;
  if (new Set(names).size === 1) common = parts[0].length - 1;
  const around = {norm: ['|', '|'], rate: ['d/dt ', '']};
  return parts.map((p) => p.slice(common).join('.')).map((text, i) => {
    const [before, after] = around[all[i].split(':')[0]] || ['', ''];
    return before + text + after;
  });
}

// Rows of curves with common times in a window: all samples, or for each short interval the lowest and the highest sample of
// each curve, in their order. The intervals have fixed boundaries, so they do not change when the window moves.
function thinned(time, curves, factors, [from, to], most = 800) {
  const [first, end] = rangeOf(time, from, to + (to - from) / 50), rows = [];
  const row = (i) => [time[i], ...curves.map((values, c) => values[i] * factors[c])];
  if (end - first <= most) {
    for (let i = first; i < end; ++i) rows.push(row(i));
    return rows;
  }
  const width = 2 * (to - from) / most;
  for (let i = first; i < end;) {
    const interval = Math.floor(time[i] / width);
    let last = i;
    while (last + 1 < end && Math.floor(time[last + 1] / width) === interval) ++last;
    const one = [time[i]], two = [time[last]];
    curves.forEach((values, c) => {
      let low = i, high = i;
      for (let k = i + 1; k <= last; ++k) {
        if (values[k] < values[low]) low = k;
        if (values[k] > values[high]) high = k;
      }
      one.push(values[Math.min(low, high)] * factors[c]);
      two.push(values[Math.max(low, high)] * factors[c]);
    });
    rows.push(one);
    if (last > i) rows.push(two);
    i = last + 1;
  }
  return rows;
}

class Plot {
  // spec: {title, signals, references}, with names of signals. `section` is the Plots, with the members that all plots share:
  // runs, visible, time, window, seek(t), synchronize(graph), edit(plot), remove(plot). Call draw() after adding `box` to the page.
  constructor(section, spec) {
    this.section = section;
    this.spec = spec;
    this.difference = false;
    this.hidden = new Set();  // names of signals that the user has hidden
    this.build();
    this.collect();
    const curves = this.series.filter((s) => !s.reference);
    this.envelope = curves.length > MANY_CURVES && curves.some((s) => s.count > 3) && this.units.length === 1;
    new ResizeObserver(() => this.graph && this.graph.resize()).observe(this.chart);
  }

  build() {
    this.box = element('article', 'plot');
    const head = element('div', 'plot-head');
    const title = element('h3');
    this.fold = button(this.spec.title, 'fold or unfold', () => this.setFolded(!this.folded));
    this.fold.className = 'fold';
    this.unit = element('span', 'unit');
    title.append(this.fold, document.createTextNode(' '), this.unit);
    const actions = element('span', 'actions');
    this.differenceButton = button('difference', 'actual minus reference', () => {
      this.difference = !this.difference;
      this.draw();
    });
    this.envelopeButton = button('envelope', 'band from the lowest to the highest signal, and their mean', () => {
      this.envelope = !this.envelope;
      this.draw();
    });
    actions.append(this.differenceButton, this.envelopeButton,
                   button('+', 'add signals to this plot', () => this.section.edit(this)),
                   button('SVG', 'save as a vector picture', () => saveSvg(pictureOf(this), this.name)),
                   button('PNG', 'save as a picture', () => savePng(pictureOf(this), this.name)),
                   button('CSV', 'save the visible curves as numbers', () => saveFile(new Blob([this.csv()], {type: 'text/csv'}), this.name, 'csv')),
                   button('✕', 'remove this plot', () => this.section.remove(this)));
    head.append(title, actions);
    this.body = element('div');
    this.readout = element('div', 'readout');
    this.area = element('div', 'area');
    this.chart = named(element('div', 'chart'), this.spec.title, 'img');
    this.cursor = element('div', 'cursor');
    this.area.append(this.chart, this.cursor);
    this.body.append(this.readout, this.area, this.resizer());
    this.box.append(head, this.body);
    this.setFolded(false);
  }

  // The lower edge, which resizes the plot by dragging or with the arrow keys; a double click restores the height.
  resizer() {
    const edge = named(element('div', 'resize'), `height of ${this.spec.title}`, 'separator');
    edge.tabIndex = 0;
    edge.setAttribute('aria-orientation', 'horizontal');
    edge.title = 'drag to resize, double-click to restore the height';
    const set = (height) => this.area.style.setProperty('--height', `${Math.max(60, height)}px`);
    edge.onpointerdown = (down) => {
      const from = this.area.clientHeight;
      edge.setPointerCapture(down.pointerId);
      edge.onpointermove = (move) => set(from + move.clientY - down.clientY);
    };
    edge.onpointerup = () => edge.onpointermove = null;
    edge.ondblclick = () => this.area.style.removeProperty('--height');
    edge.onkeydown = (event) => {
      const step = {ArrowDown: 20, ArrowUp: -20}[event.key];
      if (!step) return;
      set(this.area.clientHeight + step);
      event.preventDefault();
      event.stopPropagation();
    };
    return edge;
  }

  setFolded(folded) {
    this.folded = folded;
    this.fold.setAttribute('aria-expanded', String(!folded));
    this.body.hidden = folded;
    this.box.classList.toggle('folded', folded);
    if (!folded && this.series) this.draw();
  }

  // Finds the signals of this plot in all runs. Colours distinguish signals, or runs if there are several.
  collect() {
    this.series = [];
    this.section.runs.forEach((run, r) => {
      const find = (names) => names.flatMap((name) => run.find(name));
      const signals = find(this.spec.signals);
      const add = (signal, pair, reference) => this.series.push({run: r, signal, pair, reference, ...measure(signal.values)});
      signals.forEach((signal, i) => add(signal, i, false));
      find(this.spec.references || []).forEach((signal, i) => add(signal, i, true));
      for (const s of this.series.filter((s) => s.run === r)) s.count = signals.length;
    });
    const signals = this.series.filter((s) => !s.reference);
    shortNames(signals.map((s) => s.signal.name)).forEach((label, i) => signals[i].label = label);
    for (const s of this.series) {
      if (!s.reference) continue;
      s.of = signals.find((o) => o.run === s.run && o.pair === s.pair);
      if (s.of) s.of.by = s;
      s.label = (s.of ? s.of.label : s.signal.name.split('.').pop()) + ' ref';
    }
    this.scale();
    this.differenceButton.hidden = signals.length === 0 || !signals.every((s) => s.by);
    this.envelopeButton.hidden = signals.length < 3 || this.units.length > 1;
    this.makeReadout();
  }

  // Chooses units and decimals that suit the values.
  scale() {
    const units = [...new Set(this.series.map((s) => s.signal.unit))];
    const human = new Map(units.map((unit) => [unit, humanUnit(unit, Math.max(0, ...this.series
        .filter((s) => s.signal.unit === unit).flatMap((s) => [Math.abs(s.low), Math.abs(s.high)]).filter(Number.isFinite)))]));
    for (const s of this.series) {
      Object.assign(s, human.get(s.signal.unit));
      s.digits = digitsFor({low: s.low * s.factor, high: s.high * s.factor});
    }
    for (const s of this.series) if (s.of) s.digits = s.of.digits;
    this.digits = digitsFor({low: Math.min(...this.series.map((s) => s.low * s.factor)),
                             high: Math.max(...this.series.map((s) => s.high * s.factor))});
    this.units = [...new Set([...human.values()].map((h) => h.unit))].filter((unit) => unit);
    this.unit.textContent = this.units.length ? `[${this.units.join(', ')}]` : '';
  }

  colorOf(s) {
    if (this.section.runs.length === 1) return Theme.series(s.pair);
    return s.count > 1 ? fade(Theme.series(s.run), 0.6 * s.pair / (s.count - 1)) : Theme.series(s.run);
  }

  // The title, with the name of the group if another plot has the same title.
  get name() {
    const {title, group} = this.spec, same = (plot) => plot !== this && plot.spec.title === title;
    return group && this.section.plots.some(same) ? `${group}: ${title}` : title;
  }

  strokeOf(s) {
    return {strokePattern: s.reference ? [5, 4] : null, strokeWidth: s.noise > 0.15 ? 0.8 : s.reference ? 1.3 : 1.6};
  }

  makeReadout() {
    this.readout.replaceChildren();
    this.lines = this.section.runs.map((run) => {
      const line = element('div');
      if (this.section.runs.length > 1) line.append(element('b', '', run.name));
      line.span = element('span');
      line.append(line.span);
      this.readout.append(line);
      return line;
    });
    for (const s of this.series) {
      if (s.reference && s.of) continue;
      s.item = button('', 'show or hide', () => {
        if (!this.hidden.delete(s.signal.name)) this.hidden.add(s.signal.name);
        this.draw();
      });
      s.item.setAttribute('aria-label', `show ${s.label}`);
      s.swatch = element('b', '', s.reference ? '╌ ' : '━ ');
      s.text = element('span');
      s.item.append(s.swatch, document.createTextNode(s.label + ' '), s.text);
      this.lines[s.run].append(s.item);
    }
  }

  // The visible curves in drawing order: smooth curves come last, so they are drawn over noisy ones.
  shown() {
    const on = (s) => this.section.visible[s.run] && !this.hidden.has(s.signal.name) &&
        !(s.of && this.hidden.has(s.of.signal.name)) && !((this.difference || this.envelope) && s.reference);
    return this.series.filter(on).sort((a, b) => b.noise - a.noise);
  }

  // The value of a curve at time t, in the unit shown.
  valueAt(s, t) {
    const {time, values} = s.signal;
    return time.length === 0 ? NaN : values[indexAt(time, t)] * s.factor;
  }
  differenceAt(s, t) {
    return this.valueAt(s, t) - this.valueAt(s.by, t);
  }

  // Rows of all curves in one table, with null where a curve has no sample at that time. If the window follows the newest
  // samples, the rows are thinned.
  table(shown) {
    const {following, window} = this.section;
    if (following && !this.difference && shown.every((s) => s.signal.times === shown[0].signal.times))
      return thinned(shown[0].signal.time, shown.map((s) => s.signal.values), shown.map((s) => s.factor), window);
    const rows = new Map();
    const put = (t, column, value) => {
      let row = rows.get(t);
      if (!row) rows.set(t, row = [t].concat(new Array(shown.length).fill(null)));
      row[column + 1] = value;
    };
    shown.forEach((s, column) => {
      const {time, values} = s.signal;
      const [first, end] = following ? rangeOf(time, ...window) : [0, time.length];
      for (let i = first; i < end; ++i)
        put(time[i], column, this.difference ? this.differenceAt(s, time[i]) : values[i] * s.factor);
    });
    return [...rows.values()].sort((a, b) => a[0] - b[0]);
  }

  // Rows with one envelope for each run: [lowest, mean, highest] of its signals.
  envelopes(shown) {
    const runs = [...new Set(shown.map((s) => s.run))].sort();
    const rows = new Map();
    runs.forEach((r, column) => {
      const own = shown.filter((s) => s.run === r);
      const {following, window} = this.section;
      const timesOf = ({signal: {time}}) => [...(following ? time.subarray(...rangeOf(time, ...window)) : time)];
      const several = own.some((s) => s.signal.times !== own[0].signal.times);
      for (const t of new Set((several ? own : own.slice(0, 1)).flatMap(timesOf))) {
        const values = own.map((s) => this.difference ? this.differenceAt(s, t) : this.valueAt(s, t));
        let row = rows.get(t);
        if (!row) rows.set(t, row = [t].concat(runs.map(() => [null, null, null])));
        row[column + 1] = [Math.min(...values), values.reduce((sum, v) => sum + v, 0) / values.length, Math.max(...values)];
      }
    });
    return {runs, rows: [...rows.values()].sort((a, b) => a[0] - b[0])};
  }

  // Draws the same curves with new samples or another window. About once a second their ranges are measured again.
  update(now) {
    if (this.folded) return;
    if (!(now - this.measured < 1000)) {
      this.measured = now;
      const before = this.units.join();
      for (const s of this.series) Object.assign(s, measure(s.signal.values));
      this.scale();
      const reordered = now - this.ordered > 10000 && this.shown().some((s, i) => s !== this.curves[i]);
      if (!this.graph || reordered || before !== this.units.join()) return this.draw();
    }
    if (!this.graph) return;
    const rows = this.envelope ? this.envelopes(this.curves).rows : this.table(this.curves);
    this.graph.updateOptions({file: rows, dateWindow: this.section.window});
    this.setTime(this.section.time);
  }

  // Draws the plot from scratch, after samples, choices or colours have changed.
  draw() {
    if (this.graph) this.graph.destroy();
    this.graph = null;
    this.chart.replaceChildren();
    this.differenceButton.setAttribute('aria-pressed', String(this.difference));
    this.envelopeButton.setAttribute('aria-pressed', String(this.envelope));
    this.lines.forEach((line, run) => line.hidden = !this.section.visible[run] || !this.series.some((s) => s.run === run));
    for (const s of this.series.filter((s) => s.item)) {
      s.swatch.style.color = this.colorOf(s);
      s.item.hidden = this.envelope;
      s.item.setAttribute('aria-pressed', String(!this.hidden.has(s.signal.name)));
    }
    const shown = this.curves = this.shown();
    this.ordered = performance.now();
    if (this.folded || shown.length === 0) return;
    let rows, labels, colors, series = {};
    if (this.envelope) {
      const {runs, rows: banded} = this.envelopes(shown);
      rows = banded;
      labels = runs.map((r) => `${r}: envelope`);
      colors = runs.map((r) => Theme.series(r));
    } else {
      rows = this.table(shown);
      labels = shown.map((s, i) => `${i}: ${s.label}`);
      colors = shown.map((s) => this.colorOf(s));
      shown.forEach((s, i) => {
        series[labels[i]] = this.strokeOf(s);
      });
    }
    this.graph = new Dygraph(this.chart, rows, {
      labels: ['time', ...labels], series, colors, legend: 'never', dateWindow: this.section.window, customBars: this.envelope,
      connectSeparatedPoints: true, highlightCircleSize: 0, yRangePad: 14,
      gridLineColor: Theme.color('--grid'), axisLineColor: Theme.color('--axis'),
      axes: {
        x: {axisLabelFormatter: (x) => `${Number(x.toPrecision(9))} s`, pixelsPerLabel: 70, axisLineWidth: 1},
        y: {axisLabelFormatter: (y) => formatNumber(y), pixelsPerLabel: 20, axisLabelWidth: 46},
      },
      clickCallback: (event) => this.section.seek(this.graph.toDataXCoord(this.graph.eventToDomCoords(event)[0])),
      zoomCallback: () => this.section.zoomed && this.section.zoomed(),
      drawCallback: (graph) => this.section.synchronize(graph),
      underlayCallback: (context, area, graph) => {
        context.save();
        context.font = '10px sans-serif';
        drawBands(this, context, area, graph);
        drawEvents(this, context, area, graph);
        drawLimits(this, context, area, graph);
        context.restore();
      },
    });
    this.setTime(this.section.time);
  }

  // The limits of the visible curves, in the unit shown: [{side, value, text}], each value once.
  limits() {
    const found = new Map();
    if (this.difference) return [];
    for (const s of this.shown()) {
      const limits = this.section.runs[s.run].limitsOf(s.signal.name);
      for (const side of ['low', 'high']) {
        if (!limits || limits[side] === null) continue;
        const value = limits[side] * s.factor;
        found.set(value, {side, value, text: `limit ${formatNumber(value)} ${s.unit}`});
      }
    }
    return [...found.values()];
  }

  setTime(t) {
    this.placeCursor();
    if (t === undefined || this.folded) return;
    const show = (value, digits) => Number.isFinite(value) ? value.toFixed(digits).replace(/^-(0\.?0*)$/, '$1') : '–';
    if (this.envelope) {
      const shown = this.shown();
      this.lines.forEach((line, r) => {
        const own = shown.filter((s) => s.run === r);
        const values = own.map((s) => this.difference ? this.differenceAt(s, t) : this.valueAt(s, t));
        if (own.length === 0) return;
        const low = values.indexOf(Math.min(...values)), high = values.indexOf(Math.max(...values));
        line.span.textContent = `${show(values[low], this.digits)} (${own[low].label}) … ` +
            `${show(values[high], this.digits)} (${own[high].label}), ${own.length} signals`;
      });
      return;
    }
    for (const line of this.lines) line.span.textContent = '';
    for (const s of this.series) {
      if (!s.item) continue;
      if (this.difference) {
        s.text.textContent = formatNumber(this.differenceAt(s, t));
      } else {
        s.text.textContent = show(this.valueAt(s, t), s.digits) + (s.by ? ` (${show(this.valueAt(s.by, t), s.by.digits)})` : '');
      }
    }
  }

  placeCursor() {
    if (!this.graph || this.section.time === undefined) return;
    const x = this.graph.toDomXCoord(this.section.time);
    const area = this.graph.getArea();
    this.cursor.hidden = !(x >= area.x - 1 && x <= area.x + area.w + 1);
    this.cursor.style.left = `${x}px`;
  }

  // The signals of the visible curves as CSV text, in SI units, named as in signals.csv.
  csv(shown = this.series.filter((s) => this.section.visible[s.run] && !this.hidden.has(s.signal.name))) {
    const rows = new Map();
    shown.forEach(({signal: {time, values}}, column) => time.forEach((t, i) => {
      if (!rows.has(t)) rows.set(t, [t, ...new Array(shown.length).fill('')]);
      rows.get(t)[column + 1] = shortest(values[i]);
    }));
    const names = shown.map(({run, signal: {name, unit}}) => (this.section.runs.length > 1 ? `${this.section.runs[run].name}: ` : '') +
        name + (unit ? ` [${unit}]` : ''));
    const lines = [...rows.values()].sort((a, b) => a[0] - b[0]);
    const cell = (text) => /[",]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text;
    return [['time [s]', ...names.map((name) => cell(name.replace(/[\0-\x1f]/g, ' ')))], ...lines].map((line) => line.join(',')).join('\n') + '\n';
  }
}
