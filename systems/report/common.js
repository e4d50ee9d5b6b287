// Functions shared by all pages: numbers, units, elements.

'use strict';

function formatNumber(value) {
  if (!Number.isFinite(value)) return '–';
  if (value !== 0 && (Math.abs(value) >= 1e6 || Math.abs(value) < 1e-4)) return value.toExponential(2);
  return String(Number(value.toPrecision(4)));
}

// Colour map from low to high values: viridis, which is also readable in grey and with colour blindness.
const SCALE = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 200, 37]];

function scaleColor(fraction) {
  const at = Math.min(Math.max(fraction, 0), 1) * (SCALE.length - 1);
  const i = Math.min(Math.floor(at), SCALE.length - 2);
  return SCALE[i].map((low, k) => Math.round(low + (at - i) * (SCALE[i + 1][k] - low)));
}

function element(tag, className, text) {
  const node = document.createElement(tag);
  if (className) node.className = className;
  if (text !== undefined) node.textContent = text;
  return node;
}

// Splits text into parts between which a line may break: after "_" and "/".
const breakable = (text) => text.split(/(?<=[_/])/).flatMap((part, i) => i ? [element('wbr'), part] : [part]);

// A button with a tooltip and a label for screen readers.
function button(text, label, click) {
  const node = element('button', '', text);
  node.type = 'button';
  node.title = label;
  if (!/[a-z]{3}/.test(text)) named(node, label);
  node.onclick = click;
  return node;
}

// "m/s^2", "kg m2" -> "m/s²", "kg m²"
const prettyUnit = (unit) => unit.replace(/\^?2\b/g, '²').replace(/\^?3\b/g, '³');

// Matches the unit at the end of a key: _m, _N_m, _m_per_s2, _per_s.
const ATOMS = '(?:rad|deg|[Hh]z|kg|us|ms|mm|m|N|s|W|J)[23]?';
const UNIT_OF_KEY = new RegExp(`_((?:${ATOMS}(?:_${ATOMS})*)(?:_per_${ATOMS}(?:_${ATOMS})*)?|per_${ATOMS}(?:_${ATOMS})*)$`);
function unitOfKey(text) {
  const [over, under] = text.split(/_?per_/);
  const words = (part) => part.split('_').join(' ').replace(/\bus\b/, 'µs').replace('deg', '°').replace('hz', 'Hz');
  return prettyUnit(under === undefined ? words(over) : `${words(over) || '1'}/${words(under)}`);
}

// "foot_error_max_m.rear_left" -> {names: ["foot error max", "rear left"], unit: "m"}: any part may end with the unit.
function parseKey(key) {
  let unit = '';
  const names = key.split('.').map((part) => {
    const found = UNIT_OF_KEY.exec(part);
    if (found) unit = unitOfKey(found[1]);
    return (found ? part.slice(0, found.index) : part).split('_').join(' ');
  });
  return {names, unit};
}

// The name of a key on one line, "foot error max, rear left" or "hardware.link.delay", and its unit.
function nameOfKey(key) {
  const {names, unit} = parseKey(key);
  return {name: names.join(UNIT_OF_KEY.test(key.split('.')[0]) ? ', ' : '.'), unit};
}

// A readable unit for an SI unit: degrees for radians, mm and ms for small values. SI value * factor = value in `unit`.
function humanUnit(unit, magnitude) {
  const [, base, per] = /^([^/]*)(.*)$/.exec(unit);
  if (base === 'rad') return {unit: `°${per}`, factor: 180 / Math.PI};
  if (magnitude > 0 && magnitude < 0.1 && (base === 'm' || unit === 's')) return {unit: `m${base}${per}`, factor: 1000};
  return {unit, factor: 1};
}

// "error_max_m" -> "error max [m]"
function label(key) {
  const {name, unit} = nameOfKey(key);
  return unit ? `${name} [${unit}]` : name;
}

// Names a node for screen readers.
function named(node, label, role) {
  node.setAttribute('aria-label', label);
  if (role) node.setAttribute('role', role);
  return node;
}

// A drop-down list with a caption; `change` receives the chosen index.
function chooser(parent, caption, names, chosen, change) {
  const box = element('label', 'chooser', caption + ' ');
  const select = element('select');
  names.forEach((name, i) => {
    const option = element('option', '', name);
    option.value = i;
    option.selected = i === chosen;
    select.append(option);
  });
  select.addEventListener('change', () => change(Number(select.value)));
  box.append(select);
  parent.append(box);
}

// Saves a file as if it were downloaded; a name of several words gets underscores.
function saveFile(blob, name, ending) {
  const link = element('a');
  link.href = URL.createObjectURL(blob);
  link.download = `${name.replace(/[^\w-]+/g, '_')}.${ending}`;
  link.click();
  URL.revokeObjectURL(link.href);
}
