// The picture of a plot for a paper: axes, legend and curves, at the zoom and with the curves that the page shows.

'use strict';

// The path of a curve through [x, y], with a gap wherever a value is missing.
function pathOf(points) {
  let path = '', drawing = false;
  for (const [x, y] of points) {
    if (Number.isFinite(y)) path += `${drawing ? 'L' : 'M'}${px(x)},${px(y)}`;
    drawing = Number.isFinite(y);
  }
  return path;
}

// Returns an SVG element, or null for a plot without a visible curve.
function pictureOf(plot, width = plot.chart.clientWidth, height = plot.chart.clientHeight + 50) {
  if (plot instanceof PathPlot) return plot.picture(width, height);
  if (!plot.graph) return null;
  return Theme.onPaper(() => {
    const drawing = svg(null, width, 0), {runs} = plot.section, shown = plot.shown();
    shape(drawing, 'title', {}, plot.name);
    // Curves: {label, color, strokeWidth, strokePattern, band: whether it has a lowest and a highest value}.
    let rows, curves;
    if (plot.envelope) {
      const banded = plot.envelopes(shown);
      rows = banded.rows;
      curves = banded.runs.map((r) => ({label: `${runs.length > 1 ? `${runs[r].name}: ` : ''}lowest, mean and highest`, color: Theme.series(r), strokeWidth: 1, band: true}));
    } else {
      rows = plot.table(shown);
      curves = shown.map((s) => ({label: (runs.length > 1 ? `${runs[s.run].name}: ` : '') + s.label, color: plot.colorOf(s), ...plot.strokeOf(s), at: plot.series.indexOf(s)}));
    }
    const top = drawLegend(drawing, [...curves].sort((a, b) => a.at - b.at), width);
    const tall = Math.max(height, top + 140);
    drawing.setAttribute('viewBox', `0 0 ${width} ${tall}`);
    drawing.setAttribute('height', tall);

    const x = {range: plot.graph.xAxisRange(), label: 'time [s]'}, y = {range: plot.graph.yAxisRange(), label: `${plot.difference ? 'difference: ' : ''}${plot.name} ${plot.unit.textContent}`};
    const {area, toX, toY} = drawAxes(drawing, width, tall, x, y, {top: top + 6, right: 12});
    const context = new SvgContext(drawing);
    context.font = '10px sans-serif';
    const scales = {toDomXCoord: toX, toDomYCoord: toY};
    drawBands(plot, context, area, scales);

    const clip = shape(shape(drawing, 'defs', {}), 'clipPath', {id: 'area'});
    shape(clip, 'rect', {x: area.x, y: area.y, width: area.w, height: area.h});
    const inside = shape(drawing, 'g', {'clip-path': 'url(#area)', 'stroke-linejoin': 'round', fill: 'none'});
    curves.forEach(({color, strokeWidth, strokePattern, band}, c) => {
      const own = rows.filter((row) => row[c + 1] !== null), parts = band ? [0, 1, 2] : [0];
      const columns = parts.map((k) => own.map((row) => band ? row[c + 1][k] : row[c + 1]));
      const points = thinned(own.map((row) => row[0]), columns, parts.map(() => 1), x.range, 4000);
      const line = (k) => points.map((row) => [toX(row[0]), toY(row[k + 1])]);
      if (band) shape(inside, 'path', {d: `${pathOf([...line(0), ...line(2).reverse()])}Z`, fill: color, 'fill-opacity': 0.15});
      shape(inside, 'path', {d: pathOf(line(band ? 1 : 0)), stroke: color, 'stroke-width': strokeWidth, 'stroke-dasharray': (strokePattern || ['none']).join(' ')});
    });
    drawEvents(plot, context, area, scales);
    drawLimits(plot, context, area, scales);
    return drawing;
  });
}

// Draws the names of the curves in rows; returns the height of these rows.
function drawLegend(drawing, curves, width) {
  const context = new SvgContext(drawing);
  context.font = '11px sans-serif';
  let x = 4, y = 13;
  for (const {label, color, strokeWidth, strokePattern, band} of curves) {
    const room = context.measureText(label).width + 40;
    if (x > 4 && x + room > width) [x, y] = [4, y + 15];
    if (band) shape(drawing, 'rect', {x, y: y - 9, width: 22, height: 10, fill: color, 'fill-opacity': 0.15});
    shape(drawing, 'line', {x1: x, x2: x + 22, y1: y - 4, y2: y - 4, stroke: color, 'stroke-width': Math.max(1.3, strokeWidth), 'stroke-dasharray': (strokePattern || ['none']).join(' ')});
    context.fillStyle = Theme.color('--ink');
    context.fillText(label, x + 27, y);
    x += room;
  }
  return y + 4;
}
