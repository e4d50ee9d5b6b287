// Vector pictures: elements of SVG, axes, and files for a paper, which have the colours of the light theme on white.

'use strict';

// Adds an SVG element to `parent`, which may be null.
function shape(parent, tag, attributes, text) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  if (text !== undefined) node.textContent = text;
  if (parent) parent.append(node);
  return node;
}
function svg(parent, width, height) {
  return shape(parent, 'svg', {viewBox: `0 0 ${width} ${height}`, width, height});
}
// A coordinate in a file: a hundredth of a pixel is enough.
const px = (value) => Number(value.toFixed(2));

// The part of a canvas context that this page uses, which draws on an SVG element instead.
class SvgContext {
  constructor(parent) {
    this.parent = parent;
    this.ruler = element('canvas').getContext('2d');
    this.setLineDash([]);
  }
  set font(font) {
    this.ruler.font = font;
    this.size = /(\d+)px/.exec(font)[1];
  }
  setLineDash(dash) {
    this.dash = dash.join(' ') || 'none';
  }
  beginPath() {
    this.path = '';
  }
  moveTo(x, y) {
    this.path += `M${px(x)},${px(y)}`;
  }
  lineTo(x, y) {
    this.path += `L${px(x)},${px(y)}`;
  }
  stroke() {
    shape(this.parent, 'path', {d: this.path, fill: 'none', stroke: this.strokeStyle, 'stroke-width': this.lineWidth, 'stroke-dasharray': this.dash});
  }
  fillRect(x, y, width, height) {
    shape(this.parent, 'rect', {x: px(x), y: px(y), width: px(width), height: px(height), fill: this.fillStyle});
  }
  fillText(text, x, y) {
    shape(this.parent, 'text', {x: px(x), y: px(y), fill: this.fillStyle, 'font-size': this.size}, text);
  }
  measureText(text) {
    return this.ruler.measureText(text);
  }
}

// Round numbers, about `count` of them, in a range: [{at, text}].
function ticksOf([low, high], count) {
  const raw = (high - low) / Math.max(1, count), power = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= 0.7 * raw), first = Math.ceil(low / step - 1e-6);
  return Array.from({length: Math.max(0, Math.floor(high / step + 1e-6) - first + 1)}, (_, i) => {
    const at = Number(((first + i) * step).toPrecision(12));
    return {at, text: Math.abs(at) >= 1e6 || (at && Math.abs(step) < 1e-4) ? at.toExponential() : String(at)};
  });
}

// Draws axes with a grid, ticks and labels into a picture of this size. x and y: {range, label, ticks (optional)}; `top` and
// `right` are kept free. Returns the area {x, y, w, h} and the functions toX, toY from values to the picture.
function drawAxes(parent, width, height, x, y, {top, right}) {
  const ruler = new SvgContext(null);
  ruler.font = '12px sans-serif';
  const wide = (text) => ruler.measureText(text).width;
  const h = height - top - 38, upright = wide(y.label) > h + 8;  // a long label stands above the axis
  const area = {y: upright ? top + 18 : top, h: upright ? h - 18 : h};
  const ticksUp = y.ticks || ticksOf(y.range, area.h / 26);
  area.x = Math.max(...ticksUp.map(({text}) => wide(text)), 10) + (upright ? 10 : 28);
  area.w = width - area.x - right;
  const toX = (value) => area.x + area.w * (value - x.range[0]) / (x.range[1] - x.range[0]);
  const toY = (value) => area.y + area.h * (1 - (value - y.range[0]) / (y.range[1] - y.range[0]));
  const bottom = area.y + area.h;
  for (const {at, text} of x.ticks || ticksOf(x.range, area.w / 70)) {
    shape(parent, 'line', {x1: px(toX(at)), x2: px(toX(at)), y1: area.y, y2: bottom, class: 'grid'});
    shape(parent, 'text', {x: px(toX(at)), y: bottom + 15, 'text-anchor': 'middle'}, text);
  }
  for (const {at, text} of ticksUp) {
    shape(parent, 'line', {x1: area.x, x2: area.x + area.w, y1: px(toY(at)), y2: px(toY(at)), class: 'grid'});
    shape(parent, 'text', {x: area.x - 6, y: px(toY(at) + 4), 'text-anchor': 'end'}, text);
  }
  shape(parent, 'path', {d: `M${area.x},${area.y}V${bottom}H${area.x + area.w}`, class: 'axis', fill: 'none'});
  shape(parent, 'text', {x: area.x + area.w / 2, y: bottom + 32, 'text-anchor': 'middle'}, x.label);
  const middle = area.y + area.h / 2;
  if (upright) shape(parent, 'text', {x: 2, y: top + 8}, y.label);
  else shape(parent, 'text', {x: 12, y: middle, 'text-anchor': 'middle', transform: `rotate(-90 12 ${middle})`}, y.label);
  return {area, toX, toY};
}

// The text of an SVG file. The style sheet of the page gives elements with a class, and text without `fill`, their looks.
function svgText(drawing) {
  return Theme.onPaper(() => {
    const holder = element('div', 'card paper'), copy = drawing.cloneNode(true);
    holder.append(copy);
    document.body.append(holder);
    for (const node of copy.querySelectorAll('[class], text:not([fill])')) {
      const style = getComputedStyle(node);
      for (const name of ['fill', 'stroke', 'stroke-width', 'font-size']) {
        if (name !== 'font-size' || node.tagName === 'text') node.setAttribute(name, style.getPropertyValue(name));
      }
      node.removeAttribute('class');
    }
    holder.remove();
    copy.setAttribute('font-family', 'Helvetica, Arial, sans-serif');
    const ground = shape(null, 'rect', {width: '100%', height: '100%', fill: '#fff'}), title = copy.querySelector('title');
    if (title && title.parentNode === copy) title.after(ground); else copy.prepend(ground);
    // XML has no control characters, not even escaped ones.
    return new XMLSerializer().serializeToString(copy).replace(/[\0-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]/g, '\ufffd');
  });
}
function saveSvg(drawing, name) {
  saveFile(new Blob([svgText(drawing)], {type: 'image/svg+xml'}), name, 'svg');
}
// Saves a picture as pixels, three for each of the page, which is sharp in print.
async function savePng(drawing, name) {
  const image = new Image(), scale = 3, canvas = element('canvas');
  image.src = 'data:image/svg+xml,' + encodeURIComponent(svgText(drawing));
  await image.decode();
  Object.assign(canvas, {width: scale * image.width, height: scale * image.height});
  canvas.getContext('2d').drawImage(image, 0, 0, canvas.width, canvas.height);
  canvas.toBlob((blob) => saveFile(blob, name, 'png'));
}
