// Dragging in the replay of a live run: pulls bodies by a spring, and moves the goal.

'use strict';

// A single shape at a given position.
class Marker {
  constructor(replay, shape) {
    this.frames = new Frames([{size: [0, 0, 0], scale: 1, ...shape}]);
    this.frames.append([0], [0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0]);
    this.cursor = new FrameCursor(this.frames);
    this.cursor.setTime(0);
    this.actor = new Actor(this.frames.shapes[0], 0, this.cursor);
    this.actor.arrowRadius = replay.runs[0].actors[0].arrowRadius;
    this.object = this.actor.object;
    replay.scene.add(this.object);
    this.set(null);
  }
  // place: position, or null to hide the shape.
  set(place, vector = [0, 0, 0]) {
    this.frames.columns = [...(place || [0, 0, 0]), 1, 0, 0, 0, ...vector, 0, place ? 1 : 0];
    this.actor.update();
  }
}

class Grab {
  // goal: a Goal, or null.
  constructor(live, replay, follower, goal) {
    Object.assign(this, {live, replay, follower, goal, held: null, latest: new Latest(live)});
    this.bodies = Object.keys((live.controls.pull || {}).bodies || {}).map(Number);
    this.canvas = replay.renderer.domElement;
    this.canvas.style.touchAction = 'none';
    replay.controls.enableKeys = false;  // the arrow keys drive the robot
    this.arrow = new Marker(replay, {kind: 'arrow', role: 'disturbances', name: 'pull'});
    this.label = element('output');
    this.label.id = 'force';
    this.label.hidden = true;
    replay.stage.append(this.label);
    if (goal) {
      this.handle = new Marker(replay, {kind: 'sphere', role: 'reference', name: 'goal', size: [this.handleRadius(), 0, 0]});
      Object.assign(this.handle.actor.material, {depthTest: false, transparent: true, opacity: 0.55});
      this.handle.object.renderOrder = 1;
    }
    live.on('pull', (pull) => this.showPull(pull));
    live.on('hello', () => this.showPull({}));
    live.on('step', () => this.showHandle());
    replay.afterRender.push(() => this.placeLabel());
    this.listen();
  }

  handleRadius() {
    return Math.max(0.35 * this.replay.bodyRadius, 0.008 * this.replay.home.getSize(new THREE.Vector3()).length());
  }

  listen() {
    const {canvas, replay} = this;
    replay.stage.addEventListener('pointerdown', (event) => {
      if (event.target !== canvas || event.button !== 0 || !this.live.drives || !this.follower.on) return;
      if (!this.press(event)) return;
      replay.controls.enabled = false;  // the camera does not move during a drag
      canvas.setPointerCapture(event.pointerId);
    }, true);
    canvas.addEventListener('pointermove', (event) => {
      if (this.held) this.drag(event);
      else if (event.buttons === 0) canvas.style.cursor = this.live.drives && this.follower.on && this.under(event) ? 'grab' : '';
    });
    for (const name of ['pointerup', 'pointercancel', 'lostpointercapture']) canvas.addEventListener(name, () => this.release());
    window.addEventListener('blur', () => this.release());
  }

  ray({clientX, clientY}) {
    const {left, top, width, height} = this.canvas.getBoundingClientRect();
    const caster = new THREE.Raycaster();
    caster.setFromCamera({x: 2 * (clientX - left) / width - 1, y: 1 - 2 * (clientY - top) / height}, this.replay.camera);
    return caster;
  }

  // The object under the mouse, {shape: index of the body, or null for the goal, point}, or null.
  under(event) {
    const caster = this.ray(event), {actors} = this.replay.runs[0];
    const hits = (object) => caster.intersectObjects(object.visible ? object.children.filter((part) => part.isMesh) : []);
    const nearest = (found) => found.sort((a, b) => a.distance - b.distance)[0];
    if (this.handle) {
      const named = actors.filter(({shape}, i) => shape.name === this.goal.name && !this.bodies.includes(i)).map(({object}) => object);
      const goal = nearest([this.handle.object, ...named].flatMap(hits));
      if (goal) return {shape: null, point: goal.point};
    }
    return nearest(this.bodies.filter((i) => actors[i])
        .flatMap((shape) => hits(actors[shape].object).map(({distance, point}) => ({distance, shape, point})))) || null;
  }

  press(event) {
    const found = this.under(event);
    if (!found) return false;
    const {shape, point} = found;
    // Drag in the plane of the picture; a goal on the ground is dragged along the ground.
    const flat = shape === null && this.goal.box[0][2] === this.goal.box[1][2];
    const normal = flat ? new THREE.Vector3(0, 0, 1) : this.replay.camera.getWorldDirection(new THREE.Vector3());
    this.held = {shape, point, plane: new THREE.Plane().setFromNormalAndCoplanarPoint(normal, point)};
    if (shape === null) this.held.offset = new THREE.Vector3(...(this.goal.place || this.bodyOfGoal())).sub(point);
    this.canvas.style.cursor = 'grabbing';
    this.drag(event);
    return true;
  }

  drag(event) {
    const {shape, point, plane, offset} = this.held;
    const target = this.ray(event).ray.intersectPlane(plane, new THREE.Vector3());
    if (!target) return;
    if (shape === null) return this.goal.set(target.add(offset).toArray());
    const numbers = (vector) => vector.toArray().map((x) => Number(x.toFixed(5)));
    this.latest.push({command: 'pull', shape, point_W: numbers(point), target_W: numbers(target)});
  }

  release() {
    if (!this.held) return;
    if (this.held.shape !== null) this.latest.push({command: 'release'});
    this.held = null;
    this.canvas.style.cursor = '';
    this.replay.controls.enabled = true;
  }

  // Shows the spring and its force to everyone who watches.
  showPull({body, point_W, target_W, force_N}) {
    this.target = body === undefined ? null : new THREE.Vector3(...target_W);
    this.arrow.set(this.target && point_W, this.target ? target_W.map((t, k) => t - point_W[k]) : undefined);
    this.label.hidden = !this.target;
    if (this.target) this.label.textContent = `${Math.hypot(...[].concat(force_N)).toFixed(0)} N at ${body.split('_').join(' ')}`;
    this.replay.requestRender();
  }

  placeLabel() {
    if (!this.target) return;
    const {x, y} = this.target.clone().project(this.replay.camera);
    this.label.style.left = `${50 + 50 * x}%`;
    this.label.style.top = `${50 - 50 * y}%`;
  }

  // The initial goal: the current position of the body that will move to it.
  bodyOfGoal() {
    const actor = this.replay.runs[0].actors.find(({shape}) => shape.name === this.goal.name);
    const place = actor ? actor.object.position : this.replay.bodyPlace();
    return this.goal.within(place.toArray());
  }

  showHandle() {
    if (!this.handle) return;
    const place = this.live.drives ? this.goal.place || this.bodyOfGoal() : null;
    this.handle.set(place);
    if (place && !this.goal.place) this.goal.show(place);
  }
}
