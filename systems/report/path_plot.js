// A plot of paths: the second element of each signal over the first, with equal scales. A dot marks the common time.

'use strict';

const isPath = (name) => name.startsWith('xy:');

class PathPlot extends Plot {
  constructor(section, spec) {
    super(section, spec);
    new ResizeObserver(() => this.draw()).observe(this.chart);
  }

  // Finds the two signals of each path in all runs: `signal` is the horizontal one, `other` the vertical one.
  collect() {
    this.series = [];
    const references = this.spec.references || [];
    this.section.runs.forEach((run, r) => {
      const add = (name, pair, reference) => {
        const [signal, other] = run.find(name);
        if (other) this.series.push({run: r, signal, other, pair, reference, name: name.slice(3), noise: 0, count: this.spec.signals.length});
      };
      this.spec.signals.forEach((name, i) => add(name, i, false));
      references.forEach((name, i) => add(name, i, true));
    });
    shortNames(this.series.map((s) => s.name)).forEach((label, i) => this.series[i].label = label + (this.series[i].reference ? ' ref' : ''));
    this.units = [];
    this.differenceButton.hidden = this.envelopeButton.hidden = true;
    this.makeReadout();
  }

  update() {
    this.draw();
  }

  draw() {
    if (!this.lines) return;
    this.chart.replaceChildren();
    this.cursor.hidden = true;
    this.dots = [];
    for (const s of this.series) {
      s.swatch.style.color = this.colorOf(s);
      s.item.setAttribute('aria-pressed', String(!this.hidden.has(s.signal.name)));
    }
    const {clientWidth: width, clientHeight: height} = this.chart;
    if (this.folded || width === 0) return;
    const card = element('div', 'card path');
    card.append(this.drawing(width, height));
    this.chart.append(card);
    this.setTime(this.section.time);
  }

  // The drawing of the visible paths, or null without any.
  drawing(width, height, legend = false) {
    const shown = this.shown(), drawing = svg(null, width, height);
    if (shown.length === 0) return legend ? null : drawing;
    const top = legend ? drawLegend(drawing, shown.map((s) => ({...this.strokeOf(s), label: this.labelOf(s), color: this.colorOf(s)})), width) : 0;
    const rangeOf = (of) => {
      let low = Infinity, high = -Infinity;
      for (const s of shown) for (const value of of(s).values) if (Number.isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
      return Number.isFinite(low) ? [low, high] : [0, 1];
    };
    const label = (signal) => `${signal.name.split('.').pop()} ${signal.unit ? `[${signal.unit}]` : ''}`;
    const x = {range: rangeOf((s) => s.signal), label: label(shown[0].signal)}, y = {range: rangeOf((s) => s.other), label: label(shown[0].other)};
    const {area} = drawAxes(svg(null, width, height), width, height, x, y, {top: top + 6, right: 12});
    const scale = Math.max(1e-6, 1.1 * (x.range[1] - x.range[0]) / area.w, 1.1 * (y.range[1] - y.range[0]) / area.h);
    const widen = ([low, high], pixels) => [(low + high - scale * pixels) / 2, (low + high + scale * pixels) / 2];
    x.range = widen(x.range, area.w);
    y.range = widen(y.range, area.h);
    const {toX, toY} = drawAxes(drawing, width, height, x, y, {top: top + 6, right: 12});
    for (const s of shown) {
      const points = Array.from(s.signal.values, (value, i) => [toX(value), toY(s.other.values[i])]);
      const {strokePattern, strokeWidth} = this.strokeOf(s), color = this.colorOf(s);
      shape(drawing, 'path', {d: pathOf(points), fill: 'none', stroke: color, 'stroke-width': strokeWidth, 'stroke-linejoin': 'round', 'stroke-dasharray': (strokePattern || ['none']).join(' ')});
      if (!legend) this.dots.push({s, toX, toY, dot: shape(drawing, 'circle', {r: 4, fill: color})});
    }
    return drawing;
  }

  labelOf(s) {
    const {runs} = this.section;
    return (runs.length > 1 ? `${runs[s.run].name}: ` : '') + s.label;
  }

  picture(width, height) {
    return Theme.onPaper(() => {
      const drawing = this.drawing(width, height, true);
      if (drawing) drawing.prepend(shape(null, 'title', {}, this.name));
      return drawing;
    });
  }

  setTime(t) {
    if (t === undefined || !this.dots) return;
    for (const {s, toX, toY, dot} of this.dots) {
      const i = indexAt(s.signal.time, t), x = s.signal.values[i], y = s.other.values[i];
      if (Number.isFinite(x) && Number.isFinite(y)) for (const [name, value] of [['cx', toX(x)], ['cy', toY(y)]]) dot.setAttribute(name, px(value));
    }
    for (const s of this.series) {
      const i = indexAt(s.signal.time, t);
      s.text.textContent = `${formatNumber(s.signal.values[i])}, ${formatNumber(s.other.values[i])}`;
    }
  }

  placeCursor() {}

  csv() {
    return super.csv(this.shown().flatMap((s) => [{run: s.run, signal: s.signal}, {run: s.run, signal: s.other}]));
  }
}
