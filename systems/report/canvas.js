// Draws bands of modes, events and limits behind the curves of a plot.

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
