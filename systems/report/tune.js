// The parameters of a live run: a list that folds by block, with sliders and number fields.

'use strict';

// The ends of a slider: the range, or from zero to twice the initial value; null if the initial value is zero. An end
// that is outside the range itself is approached to a thousandth of the slider.
function spanOf({low, high, above, below}, value) {
  const finite = Number.isFinite;
  const ends = [finite(low) ? low : Math.min(0, 2 * value), finite(high) ? high : Math.max(0, 2 * value)];
  const gap = (ends[1] - ends[0]) / 1000;
  if (finite(low) && above) ends[0] += gap;
  if (finite(high) && below) ends[1] -= gap;
  return ends[0] < ends[1] ? ends : null;
}

// One parameter, with a row for each element.
class Tuned {
  constructor(live, parameter) {
    Object.assign(this, {live, parameter, latest: new Latest(live)});
    this.start = [].concat(parameter.value);
    this.held = this.start;  // current value of the run
    this.box = element('div', 'parameter');
    const name = parameter.path.slice(parameter.path.lastIndexOf('.') + 1), {unit} = parameter;
    const texts = parameter.ranges.map(({text}) => text);
    this.commonRange = texts.every((text) => text === texts[0]);
    const head = element('div', 'head');
    head.append(element('b', '', name.split('_').join(' ')), element('span', 'unit', unit ? prettyUnit(unit) : ''),
                element('small', '', this.commonRange ? texts[0] : ''));
    head.title = `${parameter.path}${parameter.meaning ? `: ${parameter.meaning}` : ''}`;
    this.undo = button('↺', `${name}: restore the initial value`, () => this.ask(this.start));
    head.append(this.undo);
    this.rows = this.start.map((value, i) => this.makeRow(name, i, value));
    this.refusal = element('output', 'refusal');
    this.box.append(head, ...this.rows.map(({row}) => row), this.refusal);
    this.show(parameter.now || this.start);
  }

  makeRow(name, i, value) {
    const {parameter} = this, label = (parameter.elements || [])[i] || (this.start.length > 1 ? String(i) : '');
    const row = element('div', 'row'), field = element('input'), range = parameter.ranges[i], span = spanOf(range, value);
    if (!this.commonRange) row.title = range.text;
    Object.assign(field, {type: 'number', step: 'any'});
    field.onchange = () => this.askElement(i, field.valueAsNumber);
    let slider = null;
    row.append(element('span', 'element', label));
    if (span) {
      slider = element('input');
      Object.assign(slider, {type: 'range', min: span[0], max: span[1], step: 'any'});
      slider.oninput = () => {
        field.value = Number(Number(slider.value).toPrecision(4));
        this.askElement(i, field.valueAsNumber);
      };
      row.append(slider);
    }
    row.append(field);
    for (const input of row.querySelectorAll('input')) named(input, `${name} ${label}`.trim());
    return {row, field, slider};
  }

  askElement(i, value) {
    if (Number.isNaN(value)) return this.show(this.held);
    this.ask(this.held.map((old, k) => k === i ? value : old));
  }

  // Requests new values. If they are refused, shows the reason and restores the current values.
  ask(values) {
    const {path, value} = this.parameter;
    this.latest.push({command: 'parameter', path, value: Array.isArray(value) ? values : values[0]}, ({error}) => {
      this.refusal.textContent = error || '';
      if (error) this.show(this.held);
    });
  }

  show(values) {
    this.held = values;
    values.forEach((value, i) => {
      const {field, slider} = this.rows[i];
      if (!Number.isFinite(value)) field.value = '';  // infinite, which JSON cannot represent
      else if (field.value === '' || Number(field.value) !== value) field.value = Number(value.toPrecision(6));
      if (slider && slider !== document.activeElement) slider.value = value;
    });
    this.undo.hidden = values.every((value, i) => value === this.start[i]);
    this.box.classList.toggle('changed', !this.undo.hidden);
  }
}

class Tune {
  constructor(live, parent) {
    Object.assign(this, {live, parent, tuned: new Map()});
    this.box = element('details');
    this.box.id = 'tune';
    this.box.append(element('summary', '', 'Tune'));
    this.search = named(element('input'), 'part of the name of a parameter');
    Object.assign(this.search, {type: 'search', placeholder: 'part of a name'});
    this.search.oninput = () => this.filter();
    this.list = named(element('fieldset'), 'parameters');
    this.box.append(this.search, this.list);
    parent.prepend(this.box);
    live.on('parameter', ({path, value}) => this.change(path, [].concat(value)));
    live.on('hello', () => this.fill());
    live.on('change', () => this.list.disabled = !live.drives || live.ended);
    this.list.disabled = !live.drives;
    this.fill();
  }

  // Makes a group for each block; the rows of a group are made when it is opened.
  fill() {
    const groups = new Map();
    for (const parameter of this.live.parameters) {
      const block = parameter.path.slice(0, Math.max(0, parameter.path.lastIndexOf('.'))) || 'parameters';
      if (!groups.has(block)) groups.set(block, []);
      groups.get(block).push(parameter);
    }
    this.box.hidden = groups.size === 0;
    this.box.firstChild.textContent = `Tune (${this.live.parameters.length} parameters)`;
    this.tuned.clear();
    const open = new Set([...this.list.querySelectorAll('details[open]')].map(({dataset}) => dataset.block));
    this.list.replaceChildren(...[...groups].map(([block, parameters]) => {
      const group = element('details');
      group.dataset.block = block;
      group.append(element('summary', '', block));
      group.fillRows = () => {
        if (group.childElementCount > 1) return;
        for (const parameter of parameters) {
          const tuned = new Tuned(this.live, parameter);
          this.tuned.set(parameter.path, tuned);
          group.append(tuned.box);
          tuned.box.dataset.text = `${parameter.path} ${parameter.meaning || ''}`.toLowerCase();
        }
      };
      group.dataset.text = parameters.map(({path, meaning}) => `${path} ${meaning || ''}`).join('\n').toLowerCase();
      group.ontoggle = () => group.open && group.fillRows();
      group.open = open.has(block);
      return group;
    }));
    this.filter();
  }

  filter() {
    const words = this.search.value.toLowerCase().split(/\s+/).filter((word) => word);
    const found = ({dataset}) => words.every((word) => dataset.text.includes(word));
    for (const group of this.list.children) {
      group.hidden = !group.dataset.text.split('\n').some((text) => words.every((word) => text.includes(word)));
      if (words.length && !group.hidden) {
        group.fillRows();
        group.open = true;
      }
      for (const box of group.querySelectorAll('.parameter')) box.hidden = !found(box);
    }
  }

  change(path, values) {
    const tuned = this.tuned.get(path), parameter = this.live.parameters.find((p) => p.path === path);
    if (parameter) parameter.now = values;
    if (tuned) tuned.show(values);
  }
}
