// Connection to a live run: receives its messages, sends commands, and makes the page follow the run. Messages: see docs/live.md.

'use strict';

const KEPT = 120;       // seconds of samples that a page holds
const COMMANDS_HZ = 30;  // largest rate of consecutive commands

// Sends commands that follow one another quickly: each after the answer to the previous one, and only the newest.
class Latest {
  constructor(live) {
    this.live = live;
  }
  // `done` receives the answer, unless a newer command has replaced this one.
  async push(command, done) {
    this.next = {command, done};
    if (this.busy) return;
    this.busy = true;
    while (this.next) {
      const now = this.next;
      this.next = null;
      const answer = await this.live.send(now.command);
      if (now.done && !this.next) now.done(answer);
      await new Promise((resolve) => setTimeout(resolve, 1000 / COMMANDS_HZ));
    }
    this.busy = false;
  }
}

// The connection to a live run. Notifies listeners of each message by its name, and of 'change' when the driver, the state
// of the run or the connection changes.
class Live {
  // `show(report, runs)` builds the page as soon as samples are available.
  constructor(report, show) {
    Object.assign(this, {report, show, run: null, connected: false, status: {state: 'connecting', driver: null}});
    this.fresh = false;  // whether samples have arrived that are not drawn yet
    this.listeners = {};
    this.client = [...crypto.getRandomValues(new Uint8Array(8))].map((byte) => byte.toString(16).padStart(2, '0')).join('');
    this.query = new URLSearchParams({client: this.client});
    if (report.live.token) this.query.set('token', report.live.token);
    this.open();
  }

  on(name, listener) {
    (this.listeners[name] = this.listeners[name] || []).push(listener);
  }
  tell(name, data) {
    for (const listener of this.listeners[name] || []) listener(data);
  }

  get drives() {
    return this.connected && this.status.driver === this.client;
  }
  get ended() {
    return this.status.state === 'ended';
  }

  open() {
    const source = new EventSource(`events?${this.query}`);
    const receive = (name, take = () => {}) => source.addEventListener(name, ({data}) => {
      const message = JSON.parse(data);
      take(message);
      this.tell(name, message);
    });
    receive('hello', (hello) => this.greet(hello));
    receive('append', (samples) => this.append(samples));
    receive('back', ({to_s}) => this.cut(to_s));
    receive('reset', () => this.cut(-Infinity));
    receive('status', (status) => this.setStatus(status));
    for (const name of ['parameter', 'pull']) receive(name);
    source.onerror = () => {
      this.connected = false;
      if (this.ended) source.close();  // the server has exited and will not come back
      // The browser reconnects by itself after an interruption, but not after a refusal.
      if (source.readyState === EventSource.CLOSED && !this.ended) setTimeout(() => this.open(), 2000);
      this.tell('change');
    };
  }

  // Starts from an empty recording, at first and after a lost connection. A different run needs a new page.
  greet({run, description, controls, parameters, history_s}) {
    const kind = JSON.stringify([run.name, run.shapes, run.plots, controls]);
    if (this.kind && kind !== this.kind) return location.reload();
    const {plots} = run;
    Object.assign(this, {kind, plots, description, controls: controls || {}, parameters: parameters || [], history_s: history_s || 0});
    if (this.run) this.cut(-Infinity);
    else this.run = new Recording({verdict: '', good: null, figures: [], ...run});
    this.connected = true;
    this.takes = performance.now() + 10000;
    this.tell('change');
  }

  append(samples) {
    if (samples.names) this.names = samples.names;
    if (samples.values) samples.names = this.names;
    this.run.append(samples);
    if (this.run.end - this.run.start > 1.25 * KEPT) this.run.keep(this.run.end - KEPT, Infinity);
    this.fresh = true;
    if (this.run.signals.size > 0 && (this.run.frames.length > 0 || this.run.frames.shapes.length === 0)) this.begin();
    else if (!this.waiting) this.waiting = setTimeout(() => this.begin(), 500);  // the run may have only signals, or only shapes
  }

  begin() {
    clearTimeout(this.waiting);
    if (this.begun) return;
    this.begun = true;
    const plots = this.plots && this.plots.length ? this.plots : defaultPlots(this.run);
    this.show({...this.report, description: this.description || this.report.description, plots}, [this.run]);
  }

  // Removes the samples after the time `to`, to which the run was set back.
  cut(to) {
    this.run.keep(-Infinity, to);
    this.fresh = true;
  }

  setStatus(status) {
    const before = this.status;
    this.status = status;
    // Become the driver of a run that nobody drives, at first and after reconnecting.
    if (!status.driver && performance.now() < this.takes) {
      this.takes = 0;
      this.send({command: 'take'}, true);
    }
    if (['state', 'driver', 'rate_wanted', 'message'].some((key) => before[key] !== status[key])) this.tell('change');
  }

  // Sends a command and returns the answer of the run: {ok, ...}, or {error} with the reason of the refusal. Listeners of
  // 'answer' receive it, too.
  async send(command, quiet = false) {
    let answer;
    try {
      const response = await fetch(`command?${this.query}`,
                                   {method: 'POST', headers: {'Content-Type': 'application/json'}, body: JSON.stringify(command)});
      answer = await response.json();
    } catch {
      answer = {error: 'the run cannot be reached'};
    }
    if (!quiet) this.tell('answer', {command, answer});
    return answer;
  }
}

// One plot for the signals of one unit whose names differ only in the last part.
function defaultPlots(run) {
  const plots = new Map();
  for (const {name, unit} of run.signals.values()) {
    const title = name.includes('.') ? name.slice(0, name.lastIndexOf('.')) : name, key = `${title} ${unit}`;
    if (!plots.has(key)) plots.set(key, {title, signals: []});
    plots.get(key).signals.push(name);
  }
  return [...plots.values()];
}

// Shows the newest samples as they arrive, until the user looks at an earlier time.
class Follower {
  // page: {plots, replay (or null), clock(t): displays the time t, stop(): stops playing}.
  constructor(live, page) {
    Object.assign(this, {live, page, on: true, span: 10});
    this.button = button('● live', 'follow the newest samples (l)', () => this.on ? this.leave() : this.join());
    this.button.id = 'live';
    document.querySelector('#transport').prepend(this.button);
    const spans = [2, 5, 10, 30, 60, KEPT];
    chooser(document.querySelector('#tools'), 'window', spans.map((span) => `${span} s`), 2, (i) => {
      this.span = spans[i];
      this.join();
    });
    document.querySelector('#zoom-out').textContent = `last ${KEPT} s`;
    page.plots.zoomed = () => this.leave();
    for (const name of ['back', 'reset', 'hello']) live.on(name, () => this.join());  // the time that was shown may no longer exist
    this.showButton();
    let last = 0, slow = 0;
    const step = (now) => {
      this.step();
      // If rendering is slow, for example without a graphics card, simplify the replay.
      slow = now - last > 80 && now - last < 3000 ? slow + 1 : 0;
      last = now;
      if (slow === 10 && page.replay && page.replay.simplify()) slow = 0;
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  get start() {
    return this.live.run.start;
  }

  showButton() {
    this.button.setAttribute('aria-pressed', String(this.on));
    for (const id of ['#play', '#speed']) document.querySelector(id).hidden = this.on;  // these controls play the past
    this.live.tell('change');
  }

  join() {
    this.page.stop();
    this.on = this.live.fresh = true;
    this.showButton();
  }

  // Stops following. The plots keep their window, or with `whole` show all samples that are kept.
  leave(whole = false) {
    if (!this.on && !whole) return;
    this.on = false;
    this.page.plots.hold(this.start, whole);
    this.showButton();
  }

  step() {
    const {live, page: {plots, replay, clock}} = this;
    if (live.fresh) {
      live.fresh = false;
      const {end} = live.run, scrub = document.querySelector('#scrub');
      plots.duration = plots.longest();
      scrub.min = this.start;
      scrub.max = plots.duration;
      if (replay) replay.refresh();
      if (this.on) {
        clock(end);
        plots.follow(end, this.start, this.span);
        if (replay) replay.setTime(end);
      }
    }
    plots.drawSome();
    live.tell('step');
  }
}
