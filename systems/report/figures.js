// The table of figures: a column for each run and a row for each figure. Figures that share a name fold into one row.

'use strict';

// Formats up to three values, for example a vector, with the same number of decimals, and more values as a range.
function formatTogether(values) {
  const low = Math.min(...values), high = Math.max(...values);
  if (low === high) return formatNumber(high);
  if (values.length > 3) return `${formatNumber(low)} … ${formatNumber(high)}`;
  const digits = Math.max(0, 3 - Math.floor(Math.log10(Math.max(-low, high))));
  return values.map((value) => value.toFixed(Math.min(digits, 9))).join(', ');
}

// Formats the value with enough digits to distinguish it from each of the others.
function formatBeside(value, others) {
  const hides = (digits) => others.some((other) => other !== value && Number(other.toPrecision(digits)) === Number(value.toPrecision(digits)));
  let digits = 4;
  while (digits < 17 && hides(digits)) ++digits;
  return digits === 4 ? formatNumber(value) : String(Number(value.toPrecision(digits)));
}

function showFigures(parent, runs) {
  const rows = new Map();  // keys by their first part
  const keys = [...new Set(runs.flatMap((run) => run.figures.map((figure) => figure.name)))];
  for (const key of keys) {
    const base = key.split('.')[0];
    if (!rows.has(base)) rows.set(base, []);
    rows.get(base).push(key);
  }
  parent.hidden = keys.length === 0;
  parent.classList.toggle('one', runs.length === 1);
  parent.classList.toggle('several', runs.length > 1);

  const figureOf = (run, key) => run.figures.find((figure) => figure.name === key) || {value: null};
  const numbers = (of) => runs.flatMap((run) => of.map((key) => figureOf(run, key).value)).filter((v) => typeof v === 'number');
  const beyond = ({value, limits}) => typeof value === 'number' && limits &&
      ((limits[0] !== null && value < limits[0]) || (limits[1] !== null && value > limits[1]));

  const table = element('table');
  if (runs.length > 1) {
    const head = table.createTHead().insertRow();
    head.append(element('th'));
    runs.forEach((run, r) => {
      const cell = element('th');
      const swatch = element('span', 'swatch');
      swatch.style.background = `var(--series-${r % 8})`;
      cell.append(swatch, ...breakable(run.name));
      cell.scope = 'col';
      head.append(cell);
    });
  }
  const body = table.createTBody();

  // `of`: one key, or several keys that are shown as a range. Returns the cell of the name.
  function addRow(label, of, unit, {factor, unit: shownUnit}) {
    const row = body.insertRow();
    const head = element('th', '', label);
    head.scope = 'row';
    head.title = of.length === 1 ? of[0] : of[0].split('.')[0];
    row.append(head);
    const texts = runs.map((run) => {
      const figures = of.map((key) => figureOf(run, key)).filter((figure) => figure.value !== null);
      const values = figures.map((figure) => figure.value);
      const cell = element('td', typeof values[0] === 'string' ? 'text' : values.length > 1 ? 'many' : '');
      if (typeof values[0] === 'number') {
        const bounds = figures.flatMap((figure) => figure.limits || []).filter((limit) => limit !== null).map((limit) => limit * factor);
        cell.textContent = values.length === 1 ? formatBeside(values[0] * factor, bounds) : formatTogether(values.map((value) => value * factor));
        cell.title = values.length === 1 ? `${values[0]} ${unit}` : '';
      } else {
        cell.append(...breakable(values.length ? values.join(', ') : '–'));
      }
      if (figures.some(beyond)) {
        cell.classList.add('beyond');
        cell.title += ' beyond its limit';
        cell.setAttribute('aria-label', `${cell.textContent}, beyond its limit`);
      }
      row.append(cell);
      return cell.textContent;
    });
    const {limits} = runs.map((run) => figureOf(run, of[0])).find((figure) => figure.limits) || {};
    const shown = numbers(of).map((value) => value * factor);
    const [low, high] = (limits || [null, null]).map((limit) => limit === null ? null : formatBeside(limit * factor, shown));
    const range = low !== null && high !== null ? `${low} … ${high}` : low !== null ? `≥ ${low}` : high !== null ? `≤ ${high}` : '';
    if (runs.length === 1) row.append(element('td', 'unit', shownUnit));
    else if (shownUnit) head.append(element('span', 'unit', ` [${shownUnit}]`));
    if (range) {
      const note = element('small', '', ` ${range}`);
      note.title = 'its limits';
      head.append(note);
    }
    const same = runs.length > 1 && texts.every((text) => text === texts[0]);
    row.classList.toggle('same', same);
    if (same && row.cells[1].classList.contains('text')) {
      while (row.cells.length > 2) row.deleteCell(2);
      row.cells[1].colSpan = runs.length;
      row.cells[1].classList.add('all');
    }
    return head;
  }

  for (const of of rows.values()) {
    const {names, unit} = parseKey(of[0]);
    const human = humanUnit(unit, Math.max(0, ...numbers(of).map(Math.abs)));
    if (of.length === 1) {
      addRow(nameOfKey(of[0]).name, of, unit, human);
      continue;
    }
    const head = addRow('', of, unit, human);
    const inner = of.map((key) => addRow(parseKey(key).names.slice(1).join(', '), [key], unit, human).parentElement);
    for (const row of inner) {
      row.classList.add('inner');
      row.hidden = true;
    }
    const fold = button(names[0], 'show each', () => {
      for (const row of inner) row.hidden = !row.hidden;
      fold.setAttribute('aria-expanded', String(!inner[0].hidden));
    });
    fold.setAttribute('aria-expanded', 'false');
    head.prepend(fold);
  }
  parent.querySelector('div').append(table);
}
