// All plots: in groups, with a common time window and a common cursor.

'use strict';

class Plots {
  // `seek(t)` is called when a plot is clicked, `edit(plot)` to add signals to it.
  constructor(container, runs, specs, {seek, edit}) {
    Object.assign(this, {container, runs, seek, edit});
    this.visible = runs.map(() => true);
    this.plots = [];
    this.duration = this.longest();
    this.window = [0, this.duration];
    this.following = false;  // whether the window follows the newest samples
    for (const spec of specs) this.add(spec);
    Theme.onChange(() => this.draw());
  }

  longest() {
    return Math.max(1e-6, ...this.runs.map((run) => run.end));
  }

  // Adds a plot and returns it, or null if no run has one of its signals.
  add(spec) {
    if (!this.runs.some((run) => spec.signals.some((name) => run.find(name).length))) return null;
    const plot = new (isPath(spec.signals[0]) ? PathPlot : Plot)(this, spec);
    this.groupOf(spec.group || '').append(plot.box);
    this.plots.push(plot);
    plot.draw();
    return plot;
  }

  // The list of plots in the last group if that has this name, else in a new group.
  groupOf(name) {
    const last = this.container.lastElementChild;
    if (last && last.dataset.group === name) return last.lastElementChild;
    const group = element('section', 'group');
    group.dataset.group = name;
    const list = element('div', 'group-plots');
    if (name) {
      const heading = element('h2');
      const fold = button(name, 'fold or unfold the group', () => {
        list.hidden = !list.hidden;
        fold.setAttribute('aria-expanded', String(!list.hidden));
        for (const plot of this.plots) if (list.contains(plot.box) && !list.hidden) plot.draw();
      });
      fold.className = 'fold';
      fold.setAttribute('aria-expanded', 'true');
      heading.append(fold);
      group.append(heading);
    }
    group.append(list);
    this.container.append(group);
    return list;
  }

  remove(plot) {
    const group = plot.box.closest('.group');
    if (plot.graph) plot.graph.destroy();
    plot.graph = null;  // the observer of its size checks for null
    plot.box.remove();
    if (!group.querySelector('.plot')) group.remove();
    this.plots.splice(this.plots.indexOf(plot), 1);
  }

  extend(plot, signals) {
    plot.spec.signals = [...plot.spec.signals, ...signals.filter((name) => !plot.spec.signals.includes(name))];
    plot.collect();
    plot.draw();
  }

  foldAll(folded) {
    for (const plot of this.plots) plot.setFolded(folded);
  }

  setColumns(count) {
    this.container.style.setProperty('--columns', count);
  }

  zoomOut() {
    this.window = [0, this.duration];
    for (const plot of this.plots) if (plot.graph) plot.graph.updateOptions({dateWindow: this.window, valueRange: null});
  }

  // Applies the time window of one plot to all plots.
  synchronize(graph) {
    for (const plot of this.plots) plot.placeCursor();
    if (this.synchronizing) return;
    this.window = graph.xAxisRange();
    const [from, to] = this.window;
    this.synchronizing = true;
    for (const {graph: other} of this.plots) {
      if (!other || other === graph) continue;
      const range = other.xAxisRange();
      if (range[0] !== from || range[1] !== to) other.updateOptions({dateWindow: [from, to]});
    }
    this.synchronizing = false;
  }

  setVisible(run, visible) {
    this.visible[run] = visible;
    this.draw();
  }

  // The events of the visible runs, in order of time.
  events() {
    return this.runs.flatMap((run, r) => this.visible[r] ? run.events : []).sort((a, b) => a.time - b.time);
  }

  draw() {
    for (const plot of this.plots) plot.draw();
  }

  // Draws new samples. A window that showed the whole run is extended.
  refresh() {
    const whole = this.window[1] >= this.duration;
    this.duration = this.longest();
    if (whole) this.window = [this.window[0], this.duration];
    for (const plot of this.plots) {
      plot.collect();
      plot.draw();
    }
  }

  setTime(t) {
    this.time = t;
    for (const plot of this.plots) plot.setTime(t);
  }

  // Follows a live run: the window covers the last `span` seconds before t. drawSome then draws the visible plots step by
  // step.
  follow(t, start, span) {
    this.duration = this.longest();
    this.time = t;
    const from = Math.max(start, t - span);
    this.window = [from, from + span];
    this.following = true;
    for (const plot of this.plots) plot.stale = true;
  }
  // Stops following. The window stays as it is, or with `whole` covers everything from `start`.
  hold(start, whole) {
    this.following = false;
    this.duration = this.longest();
    if (whole) this.window = [start, this.duration];
    for (const plot of this.plots) plot.stale = true;
  }

  // Draws stale plots for some milliseconds, starting with those that have waited longest; each plot at most ten times a second.
  drawSome() {
    const start = performance.now();
    const height = window.innerHeight;
    const inView = (plot) => {
      const {top, bottom} = plot.box.getBoundingClientRect();
      return bottom > 0 && top < height && plot.box.offsetParent !== null;
    };
    const waiting = this.plots.filter((plot) => plot.stale && start - (plot.drawn || 0) > 95 && inView(plot));
    this.synchronizing = true;  // each plot sets the window itself
    for (const plot of waiting.sort((a, b) => (a.drawn || 0) - (b.drawn || 0))) {
      plot.update(start);
      plot.drawn = start;
      plot.stale = false;
      if (performance.now() - start > 8) break;
    }
    this.synchronizing = false;
  }
}
