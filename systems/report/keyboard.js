// Keys, and the page that lists them.

'use strict';

// Whether a key is for a dialog, the browser, or something that is written into.
function notForThePage({ctrlKey, altKey, metaKey, target: {tagName, type}}) {
  if (ctrlKey || altKey || metaKey || document.querySelector('dialog[open]')) return true;
  return (tagName === 'INPUT' && type !== 'range' && type !== 'checkbox') || tagName === 'SELECT' || tagName === 'TEXTAREA';
}

// keys: [{key, shift, label, help, act}]; those with one help text after another are one line of it;
// without `act` they are listed alone.
function addKeys(dialog, keys) {
  const table = element('table');
  const lines = new Map();
  for (const {label, help} of keys) lines.set(help, [...(lines.get(help) || []), label]);
  for (const [help, labels] of lines) {
    const row = table.insertRow(), cell = row.insertCell();
    labels.forEach((label, i) => cell.append(i ? ' ' : '', element('kbd', '', label)));
    row.insertCell().textContent = help;
  }
  dialog.append(element('h2', '', 'Keys'), table,
                element('p', 'note', 'In a plot: click to go there, drag to zoom, double click for all of it.'),
                button('close', 'close', () => dialog.close()));

  document.addEventListener('keydown', (event) => {
    if (notForThePage(event)) return;
    const {tagName, id} = event.target;
    const presses = ['BUTTON', 'SUMMARY', 'A'].includes(tagName) || (tagName === 'INPUT' && id !== 'scrub');
    if (presses && event.key === ' ') return;
    const found = keys.find((key) => key.act && key.key === event.key && (key.shift === undefined || key.shift === event.shiftKey));
    if (!found) return;
    found.act();
    event.preventDefault();
  });
}
