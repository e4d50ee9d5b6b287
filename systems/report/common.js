// What all pages share: numbers, units, elements.

'use strict';

function formatNumber(value) {
  if (!Number.isFinite(value)) return '–';
  if (value !== 0 && (Math.abs(value) >= 1e6 || Math.abs(value) < 1e-4)) return value.toExponential(2);
  return String(Number(value.toPrecision(4)));
}

function element(tag, className, text) {
  const node = document.createElement(tag);
  if (className) node.className = className;
  if (text !== undefined) node.textContent = text;
  return node;
}

const UNITS = {
  m: 'm', N: 'N', s: 's', rad: 'rad', us: 'µs', ms: 'ms', kg: 'kg', deg: '°', hz: 'Hz', m_per_s: 'm/s', m_per_s2: 'm/s²',
  N_per_s: 'N/s', N_per_m: 'N/m', rad_per_s: 'rad/s', N_m: 'N m', W: 'W', J: 'J',
};

// "tracking_error_rms_m" -> ["tracking error rms", "m"], "foot_error_max_m.rear_left" -> ["foot error max, rear left", "m"]
function splitUnit(key) {
  const dot = key.indexOf('.');
  if (dot > 0) {
    const [name, unit] = splitUnit(key.slice(0, dot));
    if (unit) return [`${name}, ${key.slice(dot + 1).split('_').join(' ')}`, unit];
  }
  const words = key.split('_');
  for (let n = Math.min(4, words.length - 1); n > 0; --n) {
    const unit = UNITS[words.slice(-n).join('_')];
    if (unit) return [words.slice(0, -n).join(' '), unit];
  }
  return [words.join(' '), ''];
}
