// The dialog to choose from all logged signals.

'use strict';

class Picker {
  // `choose(names, target)`: target is a plot, 'together' for one new plot, or 'apart' for one new plot per name.
  constructor(dialog, runs, plots, choose) {
    Object.assign(this, {dialog, runs, plots, choose});
    this.search = named(element('input'), 'part of a name');
    Object.assign(this.search, {type: 'search', placeholder: 'part of a name'});
    this.search.oninput = () => this.filter();
    this.list = element('div', 'signals');
    this.target = named(element('select'), 'target plot');
    this.add = button('plot', 'plot the chosen signals', () => this.finish());
    const foot = element('div', 'foot');
    this.count = element('span', 'note');
    foot.append(this.target, this.add, button('close', 'close without plotting', () => dialog.close()), this.count);
    dialog.append(element('h2', '', 'Signals'), this.search, this.list, foot);
    this.list.onchange = () => this.showCount();
  }

  open(plot) {
    this.fill();
    const option = (value, text) => {
      const node = element('option', '', text);
      node.value = value;
      return node;
    };
    this.target.replaceChildren(option('together', 'in a new plot'), option('apart', 'each name in a plot of its own'),
                                ...this.plots.plots.map((p, i) => option(i, `in plot: ${p.spec.title}`)));
    this.target.value = plot ? this.plots.plots.indexOf(plot) : 'together';
    this.dialog.showModal();
    this.search.focus();
  }

  // Lists signals by the first part of their name, with a check box for each signal and one for the whole group.
  fill() {
    const stems = new Map();
    for (const run of this.runs) {
      for (const {name, unit} of run.signals.values()) {
        const stem = name.slice(0, Math.max(0, name.lastIndexOf('.'))) || name;
        if (!stems.has(stem)) stems.set(stem, {unit, names: new Set()});
        stems.get(stem).names.add(name);
      }
    }
    const box = (label, name) => {
      const node = element('label'), check = element('input');
      check.type = 'checkbox';
      check.dataset.name = name;
      node.append(check, document.createTextNode(` ${label}`));
      return node;
    };
    this.list.replaceChildren(...[...stems].map(([stem, {unit, names}]) => {
      const entry = element('details'), summary = element('summary'), inner = element('div');
      const whole = box(stem, stem);
      whole.append(element('span', 'unit', unit ? ` [${unit}]` : ''));
      summary.append(whole);
      for (const name of names) if (name !== stem) inner.append(box(name.slice(stem.length + 1), name));
      whole.firstChild.onchange = () => {
        for (const check of inner.querySelectorAll('input')) check.checked = check.disabled = whole.firstChild.checked;
      };
      entry.append(summary, inner);
      entry.dataset.text = [stem, ...names].join(' ').toLowerCase();
      return entry;
    }));
    this.filter();
    this.showCount();
  }

  filter() {
    const words = this.search.value.toLowerCase().split(/\s+/);
    for (const entry of this.list.children) entry.hidden = !words.every((word) => entry.dataset.text.includes(word));
  }

  chosen() {
    return [...this.list.querySelectorAll('input:checked:not(:disabled)')].map((check) => check.dataset.name);
  }

  showCount() {
    const count = this.chosen().length;
    this.count.textContent = count ? `${count} chosen` : 'choose signals, or unfold a line to see its elements';
    this.add.disabled = count === 0;
  }

  finish() {
    const names = this.chosen();
    this.dialog.close();
    this.choose(names, this.plots.plots[this.target.value] || this.target.value);
  }
}
