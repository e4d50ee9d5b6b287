// Handling of keys, and the dialog that lists them.

'use strict';

// Whether a key belongs to a dialog, to the browser or to a text field.
function notForThePage({ctrlKey, altKey, metaKey, target: {tagName, type}}) {
  if (ctrlKey || altKey || metaKey || document.querySelector('dialog[open]')) return true;
  return (tagName === 'INPUT' && type !== 'range' && type !== 'checkbox') || tagName === 'SELECT' || tagName === 'TEXTAREA';
}

// keys: [{key, shift, label, help, act}]. Keys with the same help text share one line of the dialog; a key without `act` is
// listed but not handled here.
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
                element('p', 'note', 'In a plot: click to go to a time, drag to zoom, double-click to see the whole run.'),
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
