// Controls that move the robot of a live run: keys, sticks on the screen, a gamepad, gaits, postures, a goal and a load.

'use strict';

// A knob that returns to the centre when released. value: deflection to the right and, unless `flat`, upwards, from -1 to 1.
class Stick {
  constructor(label, flat, change) {
    this.value = [0, 0];
    this.box = named(element('div', flat ? 'stick flat' : 'stick'), label, 'img');
    this.box.title = label;
    this.knob = element('i');
    this.box.append(this.knob);
    const set = (x, y) => {
      const limit = (v) => Math.min(Math.max(v, -1), 1);
      this.value = [limit(x), flat ? 0 : limit(y)];
      this.knob.style.left = `${50 + 50 * this.value[0]}%`;
      this.knob.style.top = `${50 - 50 * this.value[1]}%`;
      change();
    };
    this.box.onpointerdown = (down) => {
      if (this.box.closest('fieldset:disabled')) return;
      this.box.setPointerCapture(down.pointerId);
      this.box.onpointermove = ({clientX, clientY}) => {
        const {left, top, width, height} = this.box.getBoundingClientRect();
        set(2 * (clientX - left) / width - 1, 1 - 2 * (clientY - top) / height);
      };
      this.box.onpointermove(down);
    };
    this.box.onpointerup = this.box.onpointercancel = () => {
      this.box.onpointermove = null;
      set(0, 0);
    };
  }
}

// [forward, sideways, yaw] of each key, as fractions of the limits; left is positive, as in the robot's frame.
const DRIVE_KEYS = {
  w: [1, 0, 0], s: [-1, 0, 0], a: [0, 1, 0], d: [0, -1, 0], q: [0, 0, 1], e: [0, 0, -1],
  ArrowUp: [1, 0, 0], ArrowDown: [-1, 0, 0], ArrowLeft: [0, 1, 0], ArrowRight: [0, -1, 0],
};
const SLOW = 0.5;  // fraction of the limits for a key without shift

// Forward, sideways and yaw velocity from keys, sticks and gamepad.
class Velocity {
  constructor(live, limits, parent) {
    Object.assign(this, {live, limits: [limits.forward, limits.sideways, limits.yaw], held: new Map(), sent: '0,0,0'});
    this.latest = new Latest(live);
    const show = () => this.update();
    this.stick = new Stick('stick: forward and sideways', false, show);
    this.yaw = new Stick('stick: yaw', true, show);
    this.text = element('output');
    const sticks = element('div', 'sticks');
    sticks.append(this.stick.box, this.yaw.box, this.text);
    parent.append(sticks);
    this.listen();
    live.on('step', () => this.update());
    this.show([0, 0, 0]);
  }

  listen() {
    document.addEventListener('keydown', (event) => {
      const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
      if (!DRIVE_KEYS[key] || notForThePage(event) || !this.live.drives) return;
      if (event.target.type === 'range' && event.target.id !== 'scrub' && key.length > 1) return;  // arrow keys move a focused slider
      this.held.set(key, event.shiftKey ? 1 : SLOW);
      this.update();
      event.preventDefault();
    });
    document.addEventListener('keyup', ({key}) => {
      this.held.delete(key.length === 1 ? key.toLowerCase() : key);
      this.update();
    });
    const release = () => {
      this.held.clear();
      this.update();
    };
    window.addEventListener('blur', release);
    document.addEventListener('visibilitychange', release);
  }

  // Deflections of a gamepad: left stick for forward and sideways, right stick for yaw.
  gamepad() {
    const pad = [...(navigator.getGamepads ? navigator.getGamepads() : [])].find((p) => p && p.axes.length >= 2);
    if (!pad) return [0, 0, 0];
    const axis = (i) => Math.abs(pad.axes[i] || 0) > 0.12 ? -pad.axes[i] : 0;
    return [axis(1), axis(0), axis(2)];
  }

  update() {
    const sum = this.gamepad();
    const add = (shares, by) => shares.forEach((share, k) => sum[k] += by * share);
    add([this.stick.value[1], -this.stick.value[0], -this.yaw.value[0]], 1);
    for (const [key, by] of this.held) add(DRIVE_KEYS[key], by);
    const velocity = sum.map((share, k) => {
      const [low, high] = this.limits[k];
      return Number((share < 0 ? Math.max(share, -1) * -low : Math.min(share, 1) * high).toFixed(3)) || 0;
    });
    if (!this.live.drives) this.sent = '0,0,0';
    if (!this.live.drives || velocity.join() === this.sent) return;
    this.sent = velocity.join();
    this.show(velocity);
    this.latest.push({command: 'drive', velocity});
  }

  show([forward, sideways, yaw]) {
    this.text.textContent = `${forward.toFixed(2)} m/s forward\n${sideways.toFixed(2)} m/s to the left\n${yaw.toFixed(2)} rad/s`;
  }
}

// The goal of the platform or the person, set by numbers here or by dragging in the replay.
class Goal {
  constructor(live, {name, box}, parent) {
    Object.assign(this, {live, name, box, place: null, latest: new Latest(live)});
    const row = element('form', 'row');
    row.append(element('span', '', `${name}: goal`));
    this.fields = ['x', 'y', 'z'].map((axis, k) => {
      const field = named(element('input'), `${name}: ${axis} in m`);
      Object.assign(field, {type: 'number', step: 'any', min: box[0][k], max: box[1][k], title: `${axis}: ${box[0][k]} … ${box[1][k]} m`});
      field.hidden = box[0][k] === box[1][k];
      row.append(field);
      return field;
    });
    row.append(element('span', 'unit', 'm'), button('go', 'move to this goal', () => {}));
    row.lastChild.type = 'submit';
    row.onsubmit = (event) => {
      event.preventDefault();
      this.set(this.fields.map((field) => Number(field.value)));
    };
    parent.append(row);
    live.on('reset', () => this.place = null);
  }

  set(place) {
    this.place = this.within(place);
    this.show(this.place);
    this.latest.push({command: 'goal', position: this.place});
  }
  within(place) {
    return place.map((p, k) => Number(Math.min(Math.max(p, this.box[0][k]), this.box[1][k]).toFixed(4)));
  }
  show(place) {
    this.fields.forEach((field, k) => {
      if (field !== document.activeElement) field.value = Number(place[k].toFixed(3));
    });
  }
}

function addLoad(live, {name, mass_kg: [low, high], start}, parent) {
  const row = element('div', 'row'), hangs = /payload/.test(name);
  const slider = element('input'), field = element('input');
  for (const [input, type] of [[slider, 'range'], [field, 'number']])
    Object.assign(named(input, `${name}: mass in kg`), {type, min: low, max: high, step: 'any', value: start || (low + high) / 2});
  slider.oninput = () => field.value = Number(Number(slider.value).toPrecision(3));
  field.oninput = () => slider.value = field.value;
  const put = (mass) => live.send({command: 'load', mass_kg: mass});
  row.append(element('span', '', name), slider, field, element('span', 'unit', 'kg'),
             button(hangs ? 'attach' : 'drop', hangs ? 'attach the load to the platform' : 'drop the load on the robot', () => put(Number(field.value))),
             button(hangs ? 'release' : 'remove', hangs ? 'release the load' : 'remove the load', () => put(0)));
  parent.append(row);
}

// The panel with the controls that the run offers. goal: a Goal, or null.
class Drive {
  constructor(live, parent) {
    const {drive, gaits = [], postures = [], goal, load, pull} = live.controls;
    this.box = element('details');
    this.box.id = 'drive';
    this.box.open = true;
    this.box.append(element('summary', '', 'Drive'));
    const panel = named(element('fieldset'), 'drive');
    this.velocity = drive ? new Velocity(live, drive, panel) : null;
    const choices = element('div', 'choices');
    const choose = (command, names) => {
      if (names.length === 0) return;
      const row = named(element('div', 'row'), command, 'group');
      row.append(element('span', '', command), ...names.map((name) => button(name.split('_').join(' '), `${command}: ${name}`, async (event) => {
        const {ok} = await live.send({command, name});
        if (ok) for (const node of row.querySelectorAll('button')) node.setAttribute('aria-pressed', String(node === event.target));
      })));
      choices.append(row);
    };
    choose('gait', gaits);
    choose('posture', postures);
    this.goal = goal ? new Goal(live, goal, choices) : null;
    if (load) addLoad(live, load, choices);
    if (pull) choices.append(element('p', 'note', 'Press on a body in the replay and drag: a spring pulls the body at this point.'));
    panel.append(choices);
    this.box.append(panel);
    this.box.hidden = !drive && choices.childElementCount === 0;
    parent.prepend(this.box);
    const show = () => panel.disabled = !live.drives || live.ended;
    live.on('change', show);
    show();
  }
}
