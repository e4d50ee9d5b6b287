// Draws bands of modes, events and limits behind the curves of a plot, and exports a plot as a picture.

'use strict';

// The widths of texts in the font of the plots, each measured once.
const textWidths = new Map();
function widthOf(context, text) {
  if (!textWidths.has(text)) textWidths.set(text, context.measureText(text).width);
  return textWidths.get(text);
}

// Draws the modes of the first visible run as bands along the lower edge.
function drawBands(plot, context, area, graph) {
  const run = plot.section.runs.find((_, r) => plot.section.visible[r]);
  const height = 13;
  ((run && run.bands) || []).forEach(({intervals}, b) => {
    const top = area.y + area.h - (b + 1) * height;
    intervals.forEach((interval, i) => {
      const end = i + 1 < intervals.length ? intervals[i + 1].time : plot.section.duration;
      const left = Math.max(graph.toDomXCoord(interval.time), area.x);
      const right = Math.min(graph.toDomXCoord(end), area.x + area.w);
      if (right <= left) return;
      if (interval.value !== null) {  // a numeric mode
        context.fillStyle = Theme.band(Math.round(Math.abs(interval.value)));
        context.fillRect(left, top, right - left, height);
      }
      context.fillStyle = Theme.color('--soft');
      if (widthOf(context, interval.name) + 6 < right - left) context.fillText(interval.name, left + 3, top + 10);
    });
  });
}

function drawEvents(plot, context, area, graph) {
  context.strokeStyle = Theme.color('--event');
  context.fillStyle = Theme.color('--soft');
  context.lineWidth = 1;
  context.setLineDash([2, 3]);
  let free = -Infinity;  // right end of the last label
  for (const event of plot.section.events()) {
    const x = graph.toDomXCoord(event.time);
    if (x < area.x || x > area.x + area.w) continue;
    context.beginPath();
    context.moveTo(x, area.y);
    context.lineTo(x, area.y + area.h);
    context.stroke();
    const width = widthOf(context, event.label);
    const left = x + 3 + width > area.x + area.w ? x - 3 - width : x + 3;
    if (left < free || left < area.x) continue;
    context.fillText(event.label, left, area.y + 10);
    free = left + width + 6;
  }
}

// Draws each limit as a line, or as a label at the edge if the limit is outside the plot.
function drawLimits(plot, context, area, graph) {
  context.strokeStyle = context.fillStyle = Theme.color('--limit');
  context.lineWidth = 1.2;
  context.setLineDash([8, 4]);
  for (const {side, value, text} of plot.limits()) {
    const y = graph.toDomYCoord(value);
    const within = y >= area.y && y <= area.y + area.h;
    const label = within ? text : `${text} ${side === 'high' ? '↑' : '↓'}`;
    const x = area.x + area.w - widthOf(context, label) - 4;
    if (within) {
      context.beginPath();
      context.moveTo(area.x, y);
      context.lineTo(area.x + area.w, y);
      context.stroke();
      context.fillText(label, x, y > area.y + 14 ? y - 3 : y + 11);
    } else if (y < area.y === (side === 'high')) {
      context.fillText(label, x, y < area.y ? area.y + 22 : area.y + area.h - 4);
    }
  }
}

// Returns a canvas with title, legend, curves and axes of a plot.
function pictureOf(plot) {
  const scale = 2, margin = 8, head = 20, foot = 18;
  const width = plot.chart.clientWidth, height = plot.chart.clientHeight;
  const canvas = element('canvas');
  canvas.width = scale * (width + 2 * margin);
  canvas.height = scale * (height + head + foot + 2 * margin);
  const context = canvas.getContext('2d');
  context.scale(scale, scale);
  context.fillStyle = Theme.color('--panel');
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.translate(margin, margin);
  context.fillStyle = Theme.color('--ink');
  context.font = '600 13px sans-serif';
  context.fillText(`${plot.spec.title} ${plot.unit.textContent}`, 0, 13);
  context.font = '11px sans-serif';
  const place = plot.chart.getBoundingClientRect();
  const from = (node) => {
    const box = node.getBoundingClientRect();
    return [box.left - place.left, box.top - place.top + head, box.width, box.height];
  };
  for (const layer of plot.chart.querySelectorAll('canvas')) context.drawImage(layer, ...from(layer));
  context.fillStyle = Theme.color('--soft');
  context.textBaseline = 'middle';
  for (const label of plot.chart.querySelectorAll('.dygraph-axis-label')) {
    const [x, y, w, h] = from(label);
    const right = label.classList.contains('dygraph-axis-label-y');
    context.textAlign = right ? 'right' : 'center';
    context.fillText(label.textContent, right ? x + w : x + w / 2, y + h / 2);
  }
  context.textAlign = 'left';
  let x = 0;
  const shown = plot.shown();
  const legend = plot.envelope ? [] : plot.series.filter((s) => shown.includes(s));
  for (const s of legend) {
    const text = (plot.section.runs.length > 1 ? `${plot.section.runs[s.run].name}: ` : '') + s.label;
    context.fillStyle = plot.colorOf(s);
    context.fillText(s.reference ? '╌' : '━', x, head + height + 10);
    context.fillStyle = Theme.color('--ink');
    context.fillText(text, x + 14, head + height + 10);
    x += context.measureText(text).width + 26;
  }
  return canvas;
}
