// The bar below the header of a live run, with the controls of its time and of the driver.

'use strict';

const RATES = [0.1, 0.25, 0.5, 1, 2, null];  // ratios to the wall clock; null: as fast as possible

class RunBar {
  constructor(live) {
    this.live = live;
    this.follower = null;  // set when the page has been built
    this.box = named(element('section'), 'run', 'toolbar');
    this.box.id = 'run-bar';
    this.state = element('span', 'verdict');
    this.who = element('span', 'who');
    this.take = button('take over', 'become the driver of this run', () => this.ask({command: live.drives ? 'leave' : 'take'}));
    this.run = named(element('fieldset'), 'time of the run');
    this.pause = button('pause', 'pause or resume the run (space)', () => this.togglePause());
    this.tick = button('one tick', 'advance the paused run by one tick (.)', () => this.ask({command: 'tick'}));
    this.back = button('5 s back', 'set the run back by 5 s (b)', () => this.goBack(live.run.end - 5));
    this.backHere = button('back', 'set the run back', () => this.goBack(this.shownTime()));
    this.seed = named(element('input'), 'seed');
    Object.assign(this.seed, {type: 'number', min: 0, step: 1, value: 1, title: 'seed of the random numbers'});
    this.run.append(this.pause, this.tick);
    chooser(this.run, 'speed', RATES.map((rate) => rate === null ? 'as fast as possible' : `${rate}×`), RATES.indexOf(1),
            (i) => this.ask({command: 'rate', value: RATES[i]}));
    this.rate = this.run.querySelector('select');
    const reset = button('reset', 'restart the run with this seed', () => this.ask({command: 'reset', seed: Number(this.seed.value)}));
    const seedLabel = element('label', '', 'seed ');
    seedLabel.append(this.seed);
    this.stop = button('stop', 'end the run and write its results', () => this.confirmStop());
    document.querySelector('#transport').prepend(this.backHere);
    this.run.append(this.back, seedLabel, reset,
                    button('save scenario', 'save a scenario that starts with the current values', () => this.save()), this.stop);
    this.note = element('output', 'note');
    this.times = named(element('span', 'times'), 'real time', 'group');
    this.box.append(this.state, this.who, this.take, this.run, this.note, this.times);
    live.on('change', () => this.show());
    live.on('status', () => {
      this.showState();
      this.showTimes();
    });
    live.on('step', () => this.showBack());
    live.on('answer', ({command, answer}) => this.showAnswer(command, answer));
    this.show();
  }

  ask(command) {
    return this.live.send(command);
  }

  togglePause() {
    this.ask({command: this.live.status.state === 'paused' ? 'resume' : 'pause'});
  }
  changeRate(step) {
    const i = Math.min(Math.max(this.rate.selectedIndex + step, 0), RATES.length - 1);
    if (this.live.drives) this.ask({command: 'rate', value: RATES[i]});
  }

  shownTime() {
    return Number(document.querySelector('#scrub').value);
  }
  async goBack(to) {
    const answer = await this.ask({command: 'back', to_s: Math.max(to, 0)});
    if (answer.ok && this.follower) this.follower.join();
  }

  async save() {
    const answer = await this.ask({command: 'save'});
    if (answer.yaml !== undefined) saveFile(new Blob([answer.yaml], {type: 'text/yaml'}), 'scenario', 'yaml');
  }

  // Stops the run if the button is pressed twice within some seconds.
  confirmStop() {
    if (this.stop.textContent === 'really stop?') {
      this.ask({command: 'stop'});
      this.stop.textContent = 'stop';
      return;
    }
    this.stop.textContent = 'really stop?';
    setTimeout(() => this.stop.textContent = 'stop', 4000);
  }

  // Shows a refusal until the next command. The refusal of a parameter is shown at its field instead.
  showAnswer(command, {error}) {
    if (command.command === 'parameter') return;
    this.refusal = error || '';
    this.showNote();
  }
  showNote() {
    const text = this.refusal || this.live.status.message || '';
    if (this.note.textContent !== text) this.note.textContent = text;
    this.note.classList.toggle('bad', !!this.refusal);
  }

  showState() {
    const {state, rate, end_reason} = this.live.status, {connected, ended} = this.live;
    const speed = Number.isFinite(rate) ? ` at ${rate.toFixed(2)}×` : '';
    const text = ended ? `ended${end_reason ? `: ${end_reason}` : ''}` : !connected && this.live.run ? 'connection lost, trying again …' :
        !connected ? 'connecting …' : state === 'running' ? `running${speed}` : state;
    if (this.state.textContent !== text) this.state.textContent = text;
    this.state.className = `verdict ${ended ? '' : connected ? state === 'running' ? 'good' : '' : this.live.run ? 'bad' : ''}`;
  }

  // Histograms of the frames: how late they began, and how long they took to compute.
  showTimes() {
    this.times.replaceChildren(...Object.entries(this.live.status.times || {}).flatMap(([name, {below_us, count, quantiles_us}]) => {
      const bars = element('span', 'bars'), [median, most] = quantiles_us.map((us) => formatNumber(Number((us / 1000).toPrecision(2))));
      const counts = [...below_us, ['∞', count]].map(([limit, below], i) => [limit, below - (i ? below_us[i - 1][1] : 0)]);
      bars.append(...counts.map(([limit, frames]) => {
        const bar = element('i');
        bar.style.height = `${100 * Math.sqrt(frames / Math.max(...counts.map((each) => each[1])))}%`;
        bar.title = `frames ${name}: ${frames} below ${limit} µs`;
        return bar;
      }));
      return [element('span', '', `frames ${name}: ${median} ms, 99 % below ${most} ms`), bars];
    }));
  }

  showBack() {
    const {run, history_s} = this.live;
    this.backHere.hidden = !this.follower || this.follower.on || this.run.disabled;
    if (this.backHere.hidden) return;
    const time = this.shownTime(), text = `back to ${time.toFixed(2)} s`;
    if (this.backHere.textContent !== text) this.backHere.textContent = text;
    this.backHere.disabled = run.end - time > history_s;
    this.backHere.title = this.backHere.disabled ? `more than ${history_s} s back, beyond the history of the run` :
        'set the run back to the time that is shown';
  }

  show() {
    const {live} = this, {driver, state, rate_wanted} = live.status;
    this.showState();
    this.showNote();
    this.who.textContent = !live.connected ? '' : live.drives ? 'you drive' : driver ? 'another browser drives' : 'nobody drives';
    this.who.title = driver || '';
    this.take.textContent = live.drives ? 'leave' : 'take over';
    this.take.title = live.drives ? 'stop driving, so that another browser can' : 'become the driver of this run';
    this.take.hidden = !live.connected;
    this.run.disabled = !live.drives;
    this.pause.disabled = live.ended;  // an ended run can only be set back
    this.pause.textContent = state === 'paused' ? 'resume' : 'pause';
    this.tick.disabled = state !== 'paused';
    this.showBack();
    const at = RATES.indexOf(rate_wanted === undefined ? 1 : rate_wanted);
    if (at >= 0) this.rate.selectedIndex = at;
  }
}
