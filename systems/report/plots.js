// The plots: one Dygraph each, with a common window of time and a common cursor.

'use strict';

const SIGNAL_COLORS = ['#1f77b4', '#d9541e', '#2a9d5c', '#8e5bb5', '#c8960c', '#c2407f', '#1aa6a6', '#6b7280'];
const BAND_COLORS = ['#d7e8f7', '#fbe3c8', '#f8d3d0', '#ddf0dc', '#e8ddf3'];
const RUN_COLORS = ['#1f77b4', '#d9541e', '#2a9d5c', '#8e5bb5', '#c8960c', '#c2407f', '#1aa6a6', '#6b7280'];

function decode(text, Type) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return new Type(bytes.buffer);
}

// The colour with white mixed in, for the further signals of one run.
function lighten(hex, amount) {
  const mix = (at) => Math.round(parseInt(hex.slice(at, at + 2), 16) * (1 - amount) + 255 * amount);
  return `rgb(${mix(1)}, ${mix(3)}, ${mix(5)})`;
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

// Decimals that show a thousandth of what the values span.
function digitsFor(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  const span = Math.max(high - low, 1e-3 * Math.abs(high));
  return span > 0 && Number.isFinite(span) ? Math.min(Math.max(3 - Math.ceil(Math.log10(span)), 0), 9) : 3;
}

// What all names have in common up to a dot says nothing: loop.plant.euler.roll, loop.plant.euler.yaw -> roll, yaw.
function shortNames(names) {
  const parts = names.map((name) => name.split('.'));
  let common = 0;
  while (parts.length > 1 && parts.every((p) => p.length > common + 1 && p[common] === parts[0][common])) ++common;
  if (parts.length === 1) common = parts[0].length - 1;
  return parts.map((p) => p.slice(common).join('.'));
}

class Plots {
  // `seek(t)` is called when a plot is clicked.
  constructor(container, runs, duration, seek) {
    this.container = container;
    this.runs = runs;
    this.duration = duration;
    this.seek = seek;
    this.visible = runs.map(() => true);
    this.plots = [];
    const count = Math.max(0, ...runs.map((run) => run.plots.length));
    for (let i = 0; i < count; ++i) this.addPlot(i);
  }

  addPlot(index) {
    const series = [];
    this.runs.forEach((run, r) => {
      const plot = run.plots[index];
      if (!plot) return;
      const time = decode(plot.time, Float64Array);
      const signals = plot.series.filter((s) => !s.reference).length;
      plot.series.forEach((s) => {
        const color = this.runs.length === 1 ? SIGNAL_COLORS[s.pair % SIGNAL_COLORS.length] :
            lighten(RUN_COLORS[r % RUN_COLORS.length], signals > 1 ? 0.6 * s.pair / (signals - 1 || 1) : 0);
        series.push({run: r, name: s.name, unit: s.unit, reference: s.reference, pair: s.pair, color, time,
                     values: decode(s.values, Float32Array)});
      });
    });
    if (series.length === 0) return;
    const first = this.runs.find((run) => run.plots[index]).plots[index];
    shortNames(series.filter((s) => !s.reference).map((s) => s.name)).forEach((name, i) => {
      series.filter((s) => !s.reference)[i].label = name;
    });
    for (const s of series.filter((s) => s.reference)) {
      const of = series.find((o) => o.run === s.run && !o.reference && o.pair === s.pair);
      s.label = (of ? of.label : s.name.split('.').pop()) + ' ref';
    }

    const units = [...new Set(series.map((s) => s.unit))];
    const box = element('div', 'plot');
    const heading = element('h2', '', first.title);
    heading.append(element('span', 'unit', units.filter((u) => u).length ? `[${units.join(', ')}]` : ''));
    const readout = element('div', 'readout');
    const area = element('div', 'area');
    const chart = element('div', 'chart');
    const cursor = element('div', 'cursor');
    area.append(chart, cursor);
    box.append(heading, readout, area);
    this.container.append(box);

    const plot = {series, chart, cursor, lines: [], difference: false};
    for (const run of this.runs) {
      const line = element('div');
      if (this.runs.length > 1) line.append(element('b', '', run.name));
      readout.append(line);
      plot.lines.push(line);
    }
    for (const s of series) {
      s.digits = digitsFor(s.values);
      if (s.reference && series.some((o) => o.run === s.run && !o.reference && o.pair === s.pair)) continue;
      s.item = element('span');
      const swatch = element('b', '', s.reference ? '╌ ' : '━ ');
      swatch.style.color = s.color;
      s.readout = element('span');
      s.item.append(swatch, document.createTextNode(s.label + ' '), s.readout);
      plot.lines[s.run].append(s.item);
    }
    const paired = series.some((s) => s.reference) && series.every((s) => s.reference || this.referenceOf(plot, s));
    if (paired) {
      const button = element('button', '', 'show difference');
      button.title = 'actual minus reference';
      button.onclick = () => {
        plot.difference = !plot.difference;
        button.textContent = plot.difference ? 'show both' : 'show difference';
        this.draw(plot);
      };
      heading.append(button);
    }
    this.plots.push(plot);
    this.draw(plot);
    new ResizeObserver(() => plot.graph && plot.graph.resize()).observe(chart);
  }

  referenceOf(plot, s) {
    return plot.series.find((o) => o.reference && o.run === s.run && o.pair === s.pair);
  }

  shown(plot, s) {
    return this.visible[s.run] && !(plot.difference && s.reference);
  }

  // Rows of all runs in one table: a run that has no sample at a time leaves null there.
  table(plot) {
    const shown = plot.series.filter((s) => this.shown(plot, s));
    const rows = new Map();
    shown.forEach((s, column) => {
      const reference = plot.difference ? this.referenceOf(plot, s) : null;
      s.time.forEach((t, i) => {
        let row = rows.get(t);
        if (!row) rows.set(t, row = [t].concat(new Array(shown.length).fill(null)));
        row[column + 1] = s.values[i] - (reference ? reference.values[i] : 0);
      });
    });
    return {shown, rows: [...rows.values()].sort((a, b) => a[0] - b[0])};
  }

  draw(plot) {
    const {shown, rows} = this.table(plot);
    plot.lines.forEach((line, run) => line.hidden = !this.visible[run]);
    const window = plot.graph ? plot.graph.xAxisRange() : [0, this.duration];
    if (plot.graph) plot.graph.destroy();
    plot.graph = null;
    if (shown.length === 0) return;
    const labels = ['time'].concat(shown.map((s, i) => `${i}: ${s.label}`));
    const patterns = {};
    shown.forEach((s, i) => {
      patterns[labels[i + 1]] = {strokePattern: s.reference ? [5, 4] : null, strokeWidth: s.reference ? 1.2 : 1.5};
    });
    plot.graph = new Dygraph(plot.chart, rows, {
      labels, series: patterns, colors: shown.map((s) => s.color), legend: 'never', dateWindow: window,
      connectSeparatedPoints: true, highlightCircleSize: 0, yRangePad: 14, gridLineColor: '#e8ebef', axisLineColor: '#c3c9d1',
      axes: {
        x: {axisLabelFormatter: (x) => formatNumber(x) + ' s', pixelsPerLabel: 70, axisLineWidth: 1},
        y: {axisLabelFormatter: (y) => formatNumber(y), pixelsPerLabel: 20, axisLabelWidth: 46},
      },
      clickCallback: (event) => this.seek(plot.graph.toDataXCoord(plot.graph.eventToDomCoords(event)[0])),
      drawCallback: (graph) => this.synchronize(graph),
      underlayCallback: (context, area, graph) => {
        this.drawBands(context, area, graph);
        this.drawEvents(context, area, graph);
      },
    });
  }

  // The modes of the first run that is shown, as bands along the lower edge.
  drawBands(context, area, graph) {
    const run = this.runs.find((_, r) => this.visible[r]);
    const height = 13;
    context.save();
    context.font = '10px sans-serif';
    ((run && run.bands) || []).forEach((band, b) => {
      const top = area.y + area.h - (b + 1) * height;
      band.forEach((interval, i) => {
        const end = i + 1 < band.length ? band[i + 1].time : this.duration;
        const left = Math.max(graph.toDomXCoord(interval.time), area.x);
        const right = Math.min(graph.toDomXCoord(end), area.x + area.w);
        if (right <= left) return;
        context.fillStyle = BAND_COLORS[Math.round(Math.abs(interval.value)) % BAND_COLORS.length];
        context.fillRect(left, top, right - left, height);
        context.fillStyle = '#4b5563';
        if (context.measureText(interval.name).width + 6 < right - left) context.fillText(interval.name, left + 3, top + 10);
      });
    });
    context.restore();
  }

  drawEvents(context, area, graph) {
    context.save();
    context.font = '10px sans-serif';
    context.strokeStyle = '#9aa3af';
    context.fillStyle = '#667080';
    context.setLineDash([2, 3]);
    let free = -Infinity;  // where the last label ends
    const events = this.runs.flatMap((run, r) => this.visible[r] ? run.events || [] : []);
    for (const event of events.sort((a, b) => a.time - b.time)) {
      const x = graph.toDomXCoord(event.time);
      if (x < area.x || x > area.x + area.w) continue;
      context.beginPath();
      context.moveTo(x, area.y);
      context.lineTo(x, area.y + area.h);
      context.stroke();
      const width = context.measureText(event.label).width;
      const left = x + 3 + width > area.x + area.w ? x - 3 - width : x + 3;
      if (left < free || left < area.x) continue;
      context.fillText(event.label, left, area.y + 10);
      free = left + width + 6;
    }
    context.restore();
  }

  // Zooming one plot in time zooms all.
  synchronize(graph) {
    this.placeCursors();
    if (this.synchronizing) return;
    const [from, to] = graph.xAxisRange();
    this.synchronizing = true;
    for (const {graph: other} of this.plots) {
      if (!other || other === graph) continue;
      const range = other.xAxisRange();
      if (range[0] !== from || range[1] !== to) other.updateOptions({dateWindow: [from, to]});
    }
    this.synchronizing = false;
  }

  setVisible(run, visible) {
    this.visible[run] = visible;
    for (const plot of this.plots) this.draw(plot);
    this.setTime(this.time);
  }

  setTime(t) {
    this.time = t;
    this.placeCursors();
    for (const plot of this.plots) {
      for (const s of plot.series) {
        if (s.time.length === 0 || !s.item) continue;
        const i = indexAt(s.time, t);
        const reference = s.reference ? null : this.referenceOf(plot, s);
        const show = (value) => value.toFixed(s.digits).replace(/^-(0\.?0*)$/, '$1');
        if (plot.difference) {
          s.readout.textContent = formatNumber(s.values[i] - reference.values[i]);
        } else {
          s.readout.textContent = show(s.values[i]) + (reference ? ` (${show(reference.values[i])})` : '');
        }
      }
    }
  }

  placeCursors() {
    for (const {graph, cursor} of this.plots) {
      if (!graph || this.time === undefined) continue;
      const x = graph.toDomXCoord(this.time);
      const area = graph.getArea();
      cursor.hidden = !(x >= area.x - 1 && x <= area.x + area.w + 1);
      cursor.style.left = `${x}px`;
    }
  }
}
